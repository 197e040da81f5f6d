// What the C++ drivers share; the protocol and the convention are those of src/lib.rs.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstddef>
#include <fstream>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

using Row = std::vector<double>;

constexpr double kBudget = 4e6;          // nanoseconds for one operation in one process
constexpr std::size_t kSweeps = 7;       // at least

// Keeps a result by reference.
template <typename T>
inline void keep(T const& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

// What callgrind counts: it starts and dumps at this name.
extern "C" __attribute__((noinline)) inline void sweep_counted(void const* context, void (*sweep)(void const*)) {
  sweep(context);
  asm volatile("" ::: "memory"); // no tail call: the function must be left
}

// Where the numbers of boxplus stand among those of a library: ours k is theirs order[k].
using Order = std::vector<int>;

inline Row theirs(Order const& order, Row const& ours) {
  Row result(ours.size());
  for (std::size_t k = 0; k < order.size(); ++k) result[order[k]] = ours[k];
  return result;
}

template <typename V>
Row vector(Order const& order, V const& v) {
  Row result;
  for (int k : order) result.push_back(v[k]);
  return result;
}

// By rows.
template <typename M>
Row matrix(Order const& rows, Order const& columns, M const& m) {
  Row result;
  for (int i : rows)
    for (int j : columns) result.push_back(m(i, j));
  return result;
}

inline Order natural(int n) {
  Order order(n);
  for (int i = 0; i < n; ++i) order[i] = i;
  return order;
}

inline Row join(std::initializer_list<Row> parts) {
  Row all;
  for (Row const& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

struct Driver {
  std::string mode, inputs, outputs;
  Driver(int argc, char** argv) : mode(argv[1]), inputs(argv[2]), outputs(argc > 3 ? argv[3] : "") {}
};

// The inputs of one group in one scalar type, and what becomes of each of its operations.
struct Bench {
  Driver const& driver;
  std::string name;
  std::vector<Row> tau, point, a, b;

  // No rows where the harness asks for no operation of the group.
  Bench(Driver const& driver, std::string const& group, std::string const& scalar)
      : driver(driver), name(group + "." + scalar) {
    static std::map<std::string, std::array<int, 3>> const layouts{
        {"SO2", {1, 2, 2}}, {"SE2", {3, 2, 4}},     {"SO3", {3, 3, 4}},  {"SE3", {6, 3, 7}},
        {"SE23", {9, 3, 10}}, {"SGal3", {10, 4, 11}}, {"Sim2", {4, 2, 5}}, {"Sim3", {7, 3, 8}}};
    auto const [d, n, e] = layouts.at(group);
    std::ifstream file(driver.inputs + "/" + name, std::ios::binary);
    auto read = [&](int count) {
      Row row(count);
      file.read(reinterpret_cast<char*>(row.data()), count * sizeof(double));
      return row;
    };
    while (file && file.peek() != EOF) {
      tau.push_back(read(d));
      point.push_back(read(n));
      a.push_back(read(e));
      b.push_back(read(e));
    }
    if (!a.empty()) cell("empty", [](std::size_t i) { return i; }, [](std::size_t) { return Row(); });
  }

  // One operation, called with the number of a row; `flat` brings its result into the common convention.
  template <typename Call, typename Flat>
  void cell(std::string const& operation, Call const& call, Flat const& flat) const {
    std::string const cell_name = name + "." + operation;
    if (driver.mode == "eval") {
      std::ofstream out(driver.outputs + "/" + cell_name, std::ios::binary);
      for (std::size_t i = 0; i < a.size(); ++i) {
        Row const row = flat(call(i));
        out.write(reinterpret_cast<char const*>(row.data()), row.size() * sizeof(double));
      }
    } else if (driver.mode == "time") {
      time(cell_name, call);
    } else {
      std::printf("%s %zu\n", cell_name.c_str(), a.size());
      Sweep<Call> const whole{call, a.size()};
      sweep_counted(&whole, [](void const* context) {
        auto const& [call, rows] = *static_cast<Sweep<Call> const*>(context);
        sweep(call, rows);
      });
    }
  }

 private:
  template <typename Call>
  struct Sweep {
    Call const& call;
    std::size_t rows;
  };

  template <typename Call>
  static void sweep(Call const& call, std::size_t rows) {
    for (std::size_t i = 0; i < rows; ++i) {
      asm volatile("" : "+r"(i));  // as black_box does in Rust
      auto const result = call(i);
      keep(result);
    }
  }

  template <typename Call>
  void time(std::string const& cell_name, Call const& call) const {
    using Clock = std::chrono::steady_clock;
    auto since = [](Clock::time_point start) {
      return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
    };
    auto const begin = Clock::now();
    Row sweeps;
    while (sweeps.size() < kSweeps || since(begin) < kBudget) {
      auto const start = Clock::now();
      sweep(call, a.size());
      sweeps.push_back(since(start) / a.size());
    }
    std::sort(sweeps.begin(), sweeps.end());
    std::printf("%s %.3f %.3f\n", cell_name.c_str(), sweeps[0], sweeps[sweeps.size() / 2]);
  }
};
