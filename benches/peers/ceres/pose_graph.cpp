// Ceres on a pose graph: the residual of its pose-graph examples, by automatic differentiation, first pose constant.
//
// Usage: pose_graph GRAPH.g2o METHOD POSES [MAX_ITERATIONS], METHOD = lm | dogleg; the protocol is drivers/record.py's.

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace {

template <int kDim>
using Matrix = Eigen::Matrix<double, kDim, kDim, Eigen::RowMajor>;

// e = (R_iᵀ(t_j − t_i) − t, θ_j − θ_i − θ wrapped), whitened.
struct Between2d {
  static constexpr int kPose = 3;
  static constexpr int kResidual = 3;
  std::array<double, 3> measured;
  Matrix<3> sqrt_information;

  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using std::atan2, std::cos, std::sin;
    const T c = cos(a[2]), s = sin(a[2]), dx = b[0] - a[0], dy = b[1] - a[1];
    const T theta = b[2] - a[2] - measured[2];
    Eigen::Map<Eigen::Matrix<T, 3, 1>> e(residual);
    e << c * dx + s * dy - measured[0], c * dy - s * dx - measured[1], atan2(sin(theta), cos(theta));
    e.applyOnTheLeft(sqrt_information.template cast<T>());
    return true;
  }
};

// e = (R_iᵀ(t_j − t_i) − t, 2 vec(q q̄_ij)) with the quaternion's scalar part positive, whitened.
struct Between3d {
  static constexpr int kPose = 7;
  static constexpr int kResidual = 6;
  std::array<double, 7> measured;
  Matrix<6> sqrt_information;

  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector> p_a(a), p_b(b);
    const Eigen::Map<const Eigen::Quaternion<T>> q_a(a + 3), q_b(b + 3);
    const Eigen::Quaternion<T> a_from_w = q_a.conjugate();
    const Eigen::Quaternion<T> q = Eigen::Quaterniond(measured.data() + 3).template cast<T>();
    const Vector t = Eigen::Vector3d(measured.data()).template cast<T>();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> e(residual);
    e.template head<3>() = a_from_w * (p_b - p_a) - t;
    const Eigen::Quaternion<T> delta = q * (a_from_w * q_b).conjugate();
    e.template tail<3>() = T(delta.w() < T(0.0) ? -2.0 : 2.0) * delta.vec();
    e.applyOnTheLeft(sqrt_information.template cast<T>());
    return true;
  }
};

struct Seconds {
  double cpu = 0.0, wall = 0.0;
};

Seconds Now() {
  timespec cpu{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
  const auto wall = std::chrono::steady_clock::now().time_since_epoch();
  return {static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec),
          std::chrono::duration<double>(wall).count()};
}

// Copies the state after each iteration while the clock stands still.
// Bytes that the process has (VmRSS), or had at most since the mark was reset (VmHWM).
long Memory(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(field, 0) == 0) return 1024 * std::atol(line.c_str() + field.size() + 1);
  }
  return 0;
}

class Recorder : public ceres::IterationCallback {
 public:
  explicit Recorder(const std::vector<double>& state) : state_(state) {}

  void Start() {
    if (before_ < 0) {
      std::ofstream("/proc/self/clear_refs") << 5;  // the mark of the high water
      before_ = Memory("VmRSS");
    }
    started_ = Now();
  }

  void Stop() {
    const Seconds now = Now();
    elapsed_ = {elapsed_.cpu + now.cpu - started_.cpu, elapsed_.wall + now.wall - started_.wall};
    peak_ = std::max(peak_, Memory("VmHWM") - before_ - static_cast<long>(states_.size() * sizeof(double)));
  }

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    Stop();
    records_ << (states_.empty() ? "" : ", ") << '[' << summary.iteration << ", " << elapsed_.cpu << ", " << elapsed_.wall
             << ']';
    states_.insert(states_.end(), state_.begin(), state_.end());
    Start();
    return ceres::SOLVER_CONTINUE;
  }

  void Report(const std::string& status, const std::string& path) const {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(states_.data()),
               static_cast<std::streamsize>(states_.size() * sizeof(double)));
    std::cout << "{\"status\": \"" << status << "\", \"records\": ["
              << records_.str() << "], \"total\": [" << elapsed_.cpu << ", " << elapsed_.wall << "], \"peak\": "
              << peak_ << "}\n";
  }

 private:
  const std::vector<double>& state_;
  std::vector<double> states_;
  std::ostringstream records_;
  Seconds started_, elapsed_;
  long before_ = -1, peak_ = 0;
};

template <typename Between>
void AddEdge(std::istringstream& fields, std::vector<double>& state, ceres::Problem& problem) {
  constexpr int kPose = Between::kPose, kResidual = Between::kResidual;
  std::size_t i = 0, j = 0;
  auto edge = std::make_unique<Between>();
  fields >> i >> j;
  for (double& number : edge->measured) fields >> number;
  Matrix<kResidual> information;
  for (int row = 0; row < kResidual; ++row) {
    for (int column = row; column < kResidual; ++column) {
      fields >> information(row, column);
      information(column, row) = information(row, column);
    }
  }
  edge->sqrt_information = information.llt().matrixU();
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<Between, kResidual, kPose, kPose>(edge.release()), nullptr,
      state.data() + kPose * i, state.data() + kPose * j);
}

// Reads a file whose vertices 0 … n−1 come in order before the edges, as the harness writes it.
std::vector<double> ReadVertices(const std::string& path, const std::string& tag) {
  std::vector<double> state;
  std::ifstream file(path);
  for (std::string line, word; std::getline(file, line);) {
    std::istringstream fields(line);
    std::size_t id = 0;
    if (fields >> word && word == tag && fields >> id) {
      for (double number = 0.0; fields >> number;) state.push_back(number);
    }
  }
  return state;
}

template <typename Between>
int Run(const std::vector<std::string>& arguments, const std::string& vertex, const std::string& edge) {
  constexpr int kPose = Between::kPose;
  std::vector<double> state = ReadVertices(arguments[1], vertex);
  ceres::Problem problem;
  std::ifstream file(arguments[1]);
  for (std::string line, tag; std::getline(file, line);) {
    std::istringstream fields(line);
    if (fields >> tag && tag == edge) AddEdge<Between>(fields, state, problem);
  }
  if constexpr (kPose == 7) {
    for (std::size_t at = 0; at < state.size(); at += kPose) {
      Eigen::Map<Eigen::Quaterniond>(state.data() + at + 3).normalize();
      problem.SetManifold(
          state.data() + at,
          new ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::EigenQuaternionManifold>());
    }
  }
  problem.SetParameterBlockConstant(state.data());

  Recorder recorder(state);
  ceres::Solver::Options options;
  const char* threads = std::getenv("PEERS_THREADS");
  options.num_threads = threads == nullptr ? 1 : std::atoi(threads);
  options.logging_type = ceres::SILENT;
  options.update_state_every_iteration = true;
  options.callbacks.push_back(&recorder);
  if (arguments[2] == "dogleg") options.trust_region_strategy_type = ceres::DOGLEG;
  if (arguments.size() > 4) options.max_num_iterations = std::stoi(arguments[4]);
  ceres::Solver::Summary summary;
  recorder.Start();
  ceres::Solve(options, &problem, &summary);
  recorder.Stop();
  const bool limit = summary.termination_type == ceres::NO_CONVERGENCE;
  recorder.Report(limit ? "max_iterations" : summary.IsSolutionUsable() ? "converged" : "failed", arguments[3]);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv, argv + argc);
  if (arguments.size() == 2 && arguments[1] == "--version") {
    std::cout << CERES_VERSION_STRING << '\n';
    return 0;
  }
  if (arguments.size() < 4) {
    std::cerr << "usage: pose_graph --version | GRAPH.g2o lm|dogleg POSES [MAX_ITERATIONS]\n";
    return 2;
  }
  const bool spatial = !ReadVertices(arguments[1], "VERTEX_SE3:QUAT").empty();
  return spatial ? Run<Between3d>(arguments, "VERTEX_SE3:QUAT", "EDGE_SE3:QUAT")
                 : Run<Between2d>(arguments, "VERTEX_SE2", "EDGE_SE2");
}
