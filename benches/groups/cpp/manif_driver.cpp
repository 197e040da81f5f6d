// manif: right Jacobians, the same tangent as boxplus but for SGal(3), whose order is (ρ, ν, φ, ι).
#include <manif/manif.h>

#include "driver.hpp"

template <typename G>
void operations(Driver const& driver, std::string const& group, std::string const& scalar, Order const& tangent,
                Order const& element) {
  using S = typename G::Scalar;
  using T = typename G::Tangent;
  using J = typename G::Jacobian;
  Bench const bench(driver, group, scalar);
  if (bench.a.empty()) return;
  auto read = [](auto type, Order const& order, std::vector<Row> const& rows) {
    std::vector<decltype(type)> all;
    for (Row const& row : rows) {
      Row const native = theirs(order, row);
      decltype(type) x;
      for (std::size_t k = 0; k < native.size(); ++k) x.coeffs()(k) = static_cast<S>(native[k]);
      all.push_back(x);
    }
    return all;
  };
  auto const tau = read(T(), tangent, bench.tau);
  auto const a = read(G(), element, bench.a), b = read(G(), element, bench.b);
  auto x_row = [&](G const& x) { return vector(element, x.coeffs()); };
  auto t_row = [&](T const& t) { return vector(tangent, t.coeffs()); };
  auto j_row = [&](J const& j) { return matrix(tangent, tangent, j); };
  struct One { G x; J j; };
  struct Two { G x; J j, k; };
  struct Log { T t; J j; };
  struct Minus { T t; J j, k; };
  auto one = [&](One const& r) { return join({x_row(r.x), j_row(r.j)}); };
  auto two = [&](Two const& r) { return join({x_row(r.x), j_row(r.j), j_row(r.k)}); };

  bench.cell("exp", [&](auto i) { return tau[i].exp(); }, x_row);
  bench.cell("log", [&](auto i) { return a[i].log(); }, t_row);
  bench.cell("inverse", [&](auto i) { return a[i].inverse(); }, x_row);
  bench.cell("compose", [&](auto i) { return a[i].compose(b[i]); }, x_row);
  bench.cell("between", [&](auto i) { return a[i].between(b[i]); }, x_row);
  bench.cell("rplus", [&](auto i) { return a[i].rplus(tau[i]); }, x_row);
  bench.cell("rminus", [&](auto i) { return b[i].rminus(a[i]); }, t_row);
  bench.cell("adjoint", [&](auto i) { return a[i].adj(); }, j_row);
  bench.cell("jr", [&](auto i) { return tau[i].rjac(); }, j_row);
  bench.cell("jr_inv", [&](auto i) { return tau[i].rjacinv(); }, j_row);
  bench.cell("exp_jac", [&](auto i) { One r; r.x = tau[i].exp(r.j); return r; }, one);
  bench.cell("log_jac", [&](auto i) { Log r; r.t = a[i].log(r.j); return r; },
             [&](Log const& r) { return join({t_row(r.t), j_row(r.j)}); });
  bench.cell("inverse_jac", [&](auto i) { One r; r.x = a[i].inverse(r.j); return r; }, one);
  bench.cell("compose_jac", [&](auto i) { Two r; r.x = a[i].compose(b[i], r.j, r.k); return r; }, two);
  bench.cell("between_jac", [&](auto i) { Two r; r.x = a[i].between(b[i], r.j, r.k); return r; }, two);
  bench.cell("rplus_jac", [&](auto i) { Two r; r.x = a[i].rplus(tau[i], r.j, r.k); return r; }, two);
  bench.cell("rminus_jac", [&](auto i) { Minus r; r.t = b[i].rminus(a[i], r.j, r.k); return r; },
             [&](Minus const& r) { return join({t_row(r.t), j_row(r.j), j_row(r.k)}); });

  constexpr int N = G::Dim;
  if (bench.point[0].size() != N) return;  // its Galilean group acts on places, not on events
  using P = Eigen::Matrix<S, N, 1>;
  std::vector<P> points;
  for (Row const& row : bench.point) points.push_back(Eigen::Map<Eigen::Matrix<double, N, 1> const>(row.data()).template cast<S>());
  struct Act { P y; Eigen::Matrix<S, N, G::DoF> j; Eigen::Matrix<S, N, N> k; };
  bench.cell("act", [&](auto i) -> P { return a[i].act(points[i]); }, [](P const& y) { return vector(natural(N), y); });
  bench.cell("act_jac", [&](auto i) { Act r; r.y = a[i].act(points[i], r.j, r.k); return r; }, [&](Act const& r) {
    return join({vector(natural(N), r.y), matrix(natural(N), tangent, r.j), matrix(natural(N), natural(N), r.k)});
  });
}

template <typename S>
void all(Driver const& driver, std::string const& scalar) {
  Order const pose{3, 4, 5, 6, 0, 1, 2}, extended{3, 4, 5, 6, 0, 1, 2, 7, 8, 9};
  operations<manif::SO2<S>>(driver, "SO2", scalar, {0}, {0, 1});
  operations<manif::SE2<S>>(driver, "SE2", scalar, {0, 1, 2}, {2, 3, 0, 1});
  operations<manif::SO3<S>>(driver, "SO3", scalar, natural(3), natural(4));
  operations<manif::SE3<S>>(driver, "SE3", scalar, natural(6), pose);
  operations<manif::SE_2_3<S>>(driver, "SE23", scalar, natural(9), extended);
  operations<manif::SGal3<S>>(driver, "SGal3", scalar, {0, 1, 2, 6, 7, 8, 3, 4, 5, 9}, {3, 4, 5, 6, 0, 1, 2, 7, 8, 9, 10});
}

int main(int argc, char** argv) {
  Driver const driver(argc, argv);
  all<double>(driver, "f64");
  all<float>(driver, "f32");
}
