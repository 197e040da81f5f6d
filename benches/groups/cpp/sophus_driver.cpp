// Sophus: left Jacobians of SO(3) and SE(3), J_r(τ) = J_l(−τ); tangents (υ, ω) as ours, rotations of Sim by scaled numbers.
#include <cmath>

#include <sophus/se2.hpp>
#include <sophus/se3.hpp>
#include <sophus/sim2.hpp>
#include <sophus/sim3.hpp>

#include "driver.hpp"

// An element of each group from a row of ours, and back.
template <typename G>
struct Rows;

template <typename S>
struct Rows<Sophus::SO2<S>> {
  static Sophus::SO2<S> read(Row const& r) { return {S(r[0]), S(r[1])}; }
  static Row write(Sophus::SO2<S> const& x) { return {x.unit_complex().x(), x.unit_complex().y()}; }
};
template <typename S>
struct Rows<Sophus::SE2<S>> {
  static Sophus::SE2<S> read(Row const& r) { return {Sophus::SO2<S>(S(r[0]), S(r[1])), Sophus::Vector2<S>(S(r[2]), S(r[3]))}; }
  static Row write(Sophus::SE2<S> const& x) {
    return join({Rows<Sophus::SO2<S>>::write(x.so2()), vector(natural(2), x.translation())});
  }
};
template <typename S>
struct Rows<Sophus::SO3<S>> {
  static Eigen::Quaternion<S> quaternion(Row const& r) { return {S(r[3]), S(r[0]), S(r[1]), S(r[2])}; }
  static Sophus::SO3<S> read(Row const& r) { return Sophus::SO3<S>(quaternion(r)); }
  static Row write(Sophus::SO3<S> const& x) { return vector(natural(4), x.unit_quaternion().coeffs()); }
};
template <typename S>
struct Rows<Sophus::SE3<S>> {
  static Sophus::SE3<S> read(Row const& r) { return {Rows<Sophus::SO3<S>>::read(r), Sophus::Vector3<S>(S(r[4]), S(r[5]), S(r[6]))}; }
  static Row write(Sophus::SE3<S> const& x) {
    return join({Rows<Sophus::SO3<S>>::write(x.so3()), vector(natural(3), x.translation())});
  }
};
template <typename S>
struct Rows<Sophus::Sim2<S>> {
  static Sophus::Sim2<S> read(Row const& r) {
    return {Sophus::RxSO2<S>(S(std::exp(r[4])), Sophus::SO2<S>(S(r[0]), S(r[1]))), Sophus::Vector2<S>(S(r[2]), S(r[3]))};
  }
  static Row write(Sophus::Sim2<S> const& x) {
    Row const turn = Rows<Sophus::SO2<S>>::write(x.rxso2().so2());
    return join({turn, vector(natural(2), x.translation()), {std::log(double(x.scale()))}});
  }
};
template <typename S>
struct Rows<Sophus::Sim3<S>> {
  static Sophus::Sim3<S> read(Row const& r) {
    Sophus::RxSO3<S> const turn(S(std::exp(r[7])), Rows<Sophus::SO3<S>>::quaternion(r));
    return Sophus::Sim3<S>(turn, Sophus::Vector3<S>(S(r[4]), S(r[5]), S(r[6])));
  }
  static Row write(Sophus::Sim3<S> const& x) {
    Row const turn = vector(natural(4), x.quaternion().normalized().coeffs());
    return join({turn, vector(natural(3), x.translation()), {std::log(double(x.scale()))}});
  }
};

template <typename G>
void operations(Driver const& driver, std::string const& group, std::string const& scalar) {
  using S = typename G::Scalar;
  constexpr int D = G::DoF, N = G::Point::RowsAtCompileTime;
  using T = Eigen::Matrix<S, D, 1>;
  using P = Eigen::Matrix<S, N, 1>;
  Bench const bench(driver, group, scalar);
  if (bench.a.empty()) return;
  std::vector<T> tau;
  for (Row const& r : bench.tau) tau.push_back(Eigen::Map<Eigen::Matrix<double, D, 1> const>(r.data()).template cast<S>());
  std::vector<P> points;
  for (Row const& r : bench.point) points.push_back(Eigen::Map<Eigen::Matrix<double, N, 1> const>(r.data()).template cast<S>());
  std::vector<G> a, b;
  for (Row const& r : bench.a) a.push_back(Rows<G>::read(r));
  for (Row const& r : bench.b) b.push_back(Rows<G>::read(r));
  // SO(2) speaks of its tangent as a number.
  auto exp = [&](auto i) {
    if constexpr (D == 1) return G::exp(tau[i](0));
    else return G::exp(tau[i]);
  };
  auto x_row = [](G const& x) { return Rows<G>::write(x); };
  auto t_row = [](auto const& t) {
    if constexpr (D == 1) return Row{double(t)};
    else return vector(natural(D), t);
  };
  auto j_row = [](auto const& j) {
    if constexpr (D == 1) return Row{double(j)};
    else return matrix(natural(D), natural(D), j);
  };

  bench.cell("exp", exp, x_row);
  bench.cell("log", [&](auto i) { return a[i].log(); }, t_row);
  bench.cell("inverse", [&](auto i) { return a[i].inverse(); }, x_row);
  bench.cell("compose", [&](auto i) -> G { return a[i] * b[i]; }, x_row);
  bench.cell("between", [&](auto i) -> G { return a[i].inverse() * b[i]; }, x_row);
  bench.cell("act", [&](auto i) -> P { return a[i] * points[i]; }, [](P const& y) { return vector(natural(N), y); });
  bench.cell("rplus", [&](auto i) -> G { return a[i] * exp(i); }, x_row);
  bench.cell("rminus", [&](auto i) { return (a[i].inverse() * b[i]).log(); }, t_row);
  bench.cell("adjoint", [&](auto i) { return a[i].Adj(); }, j_row);
  if constexpr (N == 3 && D <= 6) {
    using J = Eigen::Matrix<S, D, D>;
    struct Minus { T t; J j, k; };
    bench.cell("jr", [&](auto i) -> J { return G::leftJacobian(-tau[i]); }, j_row);
    bench.cell("jr_inv", [&](auto i) -> J { return G::leftJacobianInverse(-tau[i]); }, j_row);
    // Composed as its user must.
    auto rminus = [&](auto i) {
      Minus r;
      r.t = (a[i].inverse() * b[i]).log();
      r.j = G::leftJacobianInverse(-r.t);
      r.k = -G::leftJacobianInverse(r.t);
      return r;
    };
    bench.cell("rminus_jac", rminus, [&](Minus const& r) { return join({t_row(r.t), j_row(r.j), j_row(r.k)}); });
  }
}

template <typename S>
void all(Driver const& driver, std::string const& scalar) {
  operations<Sophus::SO2<S>>(driver, "SO2", scalar);
  operations<Sophus::SE2<S>>(driver, "SE2", scalar);
  operations<Sophus::SO3<S>>(driver, "SO3", scalar);
  operations<Sophus::SE3<S>>(driver, "SE3", scalar);
  operations<Sophus::Sim2<S>>(driver, "Sim2", scalar);
  operations<Sophus::Sim3<S>>(driver, "Sim3", scalar);
}

int main(int argc, char** argv) {
  Driver const driver(argc, argv);
  all<double>(driver, "f64");
  all<float>(driver, "f32");
}
