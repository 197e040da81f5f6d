// Ceres on a problem of Bundle Adjustment in the Large, as its own example bundle_adjuster has it: Snavely's residual by automatic
// differentiation, points eliminated first, DENSE_SCHUR, one thread.
//
// Usage: bundle PROBLEM.txt. Prints one line an iteration, `cost cpu_seconds wall_seconds`, from the call of Solve, then `end` and the same.

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <vector>

namespace {

struct Reprojection {
  double u, v;

  template <typename T>
  bool operator()(const T* camera, const T* point, T* residual) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera, point, p);
    for (int i = 0; i < 3; ++i) p[i] += camera[3 + i];
    const T a = -p[0] / p[2], b = -p[1] / p[2], t = a * a + b * b;
    const T scale = camera[6] * (1.0 + t * (camera[7] + camera[8] * t));
    residual[0] = scale * a - u;
    residual[1] = scale * b - v;
    return true;
  }
};

double Cpu() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

double Wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Watch : ceres::IterationCallback {
  double cpu = Cpu(), wall = Wall();
  void Print(double cost) const { std::printf("%.10e %.6f %.6f\n", cost, Cpu() - cpu, Wall() - wall); }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    Print(summary.cost);
    return ceres::SOLVER_CONTINUE;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::ifstream file(argv[1]);
  int cameras = 0, points = 0, observations = 0;
  file >> cameras >> points >> observations;
  struct Seen { int camera, point; double u, v; };
  std::vector<Seen> seen(observations);
  for (auto& s : seen) file >> s.camera >> s.point >> s.u >> s.v;
  std::vector<double> x(9 * cameras + 3 * points);
  for (auto& number : x) file >> number;
  if (!file) return 3;
  double* const first_point = x.data() + 9 * cameras;

  ceres::Problem problem;
  for (const auto& s : seen) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, 9, 3>(new Reprojection{s.u, s.v}), nullptr,
                             x.data() + 9 * s.camera, first_point + 3 * s.point);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.num_threads = 1;
  options.max_num_iterations = 500;
  options.logging_type = ceres::SILENT;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (int i = 0; i < points; ++i) options.linear_solver_ordering->AddElementToGroup(first_point + 3 * i, 0);
  for (int i = 0; i < cameras; ++i) options.linear_solver_ordering->AddElementToGroup(x.data() + 9 * i, 1);
  Watch watch;
  options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  std::printf("end ");
  watch.Print(summary.final_cost);
}
