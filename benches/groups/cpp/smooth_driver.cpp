// smooth: right Jacobians, tangents (υ, ω) with the rotation last.
#include <smooth/galilei.hpp>
#include <smooth/se2.hpp>
#include <smooth/se3.hpp>
#include <smooth/se_k_3.hpp>
#include <smooth/so2.hpp>
#include <smooth/so3.hpp>

#include "driver.hpp"

template <typename G, int N>
void operations(Driver const& driver, std::string const& group, std::string const& scalar, Order const& tangent,
                Order const& element) {
  using S = typename G::Scalar;
  using T = typename G::Tangent;
  using J = typename G::TangentMap;
  Bench const bench(driver, group, scalar);
  if (bench.a.empty()) return;
  std::vector<T> tau;
  for (Row const& r : bench.tau) {
    Row const native = theirs(tangent, r);
    tau.push_back(Eigen::Map<Eigen::VectorXd const>(native.data(), native.size()).template cast<S>());
  }
  auto elements = [&](std::vector<Row> const& rows) {
    std::vector<G> all;
    for (Row const& r : rows) {
      Row const native = theirs(element, r);
      G x;
      for (std::size_t k = 0; k < native.size(); ++k) x.coeffs()(k) = static_cast<S>(native[k]);
      all.push_back(x);
    }
    return all;
  };
  auto const a = elements(bench.a), b = elements(bench.b);
  auto x_row = [&](G const& x) { return vector(element, x.coeffs()); };
  auto t_row = [&](T const& t) { return vector(tangent, t); };
  auto j_row = [&](J const& j) { return matrix(tangent, tangent, j); };
  struct One { G x; J j; };
  struct Two { G x; J j, k; };
  struct Log { T t; J j; };
  struct Minus { T t; J j, k; };

  bench.cell("exp", [&](auto i) { return G::exp(tau[i]); }, x_row);
  bench.cell("log", [&](auto i) { return a[i].log(); }, t_row);
  bench.cell("inverse", [&](auto i) { return a[i].inverse(); }, x_row);
  bench.cell("compose", [&](auto i) { return a[i] * b[i]; }, x_row);
  bench.cell("between", [&](auto i) { return a[i].inverse() * b[i]; }, x_row);
  bench.cell("rplus", [&](auto i) { return a[i] + tau[i]; }, x_row);
  bench.cell("rminus", [&](auto i) { return b[i] - a[i]; }, t_row);
  bench.cell("adjoint", [&](auto i) { return a[i].Ad(); }, j_row);
  bench.cell("jr", [&](auto i) { return G::dr_exp(tau[i]); }, j_row);
  bench.cell("jr_inv", [&](auto i) { return G::dr_expinv(tau[i]); }, j_row);
  // Composed as its user must.
  bench.cell("exp_jac", [&](auto i) { return One{G::exp(tau[i]), G::dr_exp(tau[i])}; },
             [&](One const& r) { return join({x_row(r.x), j_row(r.j)}); });
  bench.cell("log_jac", [&](auto i) { T const t = a[i].log(); return Log{t, G::dr_expinv(t)}; },
             [&](Log const& r) { return join({t_row(r.t), j_row(r.j)}); });
  bench.cell("rplus_jac", [&](auto i) {
        G const step = G::exp(tau[i]);
        return Two{a[i] * step, step.inverse().Ad(), G::dr_exp(tau[i])};
      }, [&](Two const& r) { return join({x_row(r.x), j_row(r.j), j_row(r.k)}); });
  bench.cell("rminus_jac", [&](auto i) { T const t = b[i] - a[i]; return Minus{t, G::dr_expinv(t), -G::dl_expinv(t)}; },
             [&](Minus const& r) { return join({t_row(r.t), j_row(r.j), j_row(r.k)}); });
  if constexpr (N > 0) {
    using P = Eigen::Matrix<S, N, 1>;
    std::vector<P> points;
    for (Row const& r : bench.point) points.push_back(Eigen::Map<Eigen::Matrix<double, N, 1> const>(r.data()).template cast<S>());
    bench.cell("act", [&](auto i) -> P { return a[i] * points[i]; }, [](P const& y) { return vector(natural(N), y); });
  }
}

template <typename S>
void all(Driver const& driver, std::string const& scalar) {
  operations<smooth::SO2<S>, 2>(driver, "SO2", scalar, {0}, {1, 0});
  operations<smooth::SE2<S>, 2>(driver, "SE2", scalar, {0, 1, 2}, {3, 2, 0, 1});
  operations<smooth::SO3<S>, 3>(driver, "SO3", scalar, natural(3), natural(4));
  operations<smooth::SE3<S>, 3>(driver, "SE3", scalar, natural(6), {3, 4, 5, 6, 0, 1, 2});
  operations<smooth::SE_K_3<S, 2>, 0>(driver, "SE23", scalar, {0, 1, 2, 6, 7, 8, 3, 4, 5}, {6, 7, 8, 9, 0, 1, 2, 3, 4, 5});
  operations<smooth::Galilei<S>, 0>(driver, "SGal3", scalar, {3, 4, 5, 7, 8, 9, 0, 1, 2, 6},
                                    {7, 8, 9, 10, 3, 4, 5, 0, 1, 2, 6});
}

int main(int argc, char** argv) {
  Driver const driver(argc, argv);
  all<double>(driver, "f64");
  all<float>(driver, "f32");
}
