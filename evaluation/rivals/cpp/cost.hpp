// What a piece of work takes, as src/cost.rs has it: the fastest run's time, on the clock and of the processor, and energy where
// the machine counts it (RAPL).
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

struct Cost {
  uint64_t ns = 0;
  uint64_t cpu_ns = 0;
  std::optional<double> energy_uj;
};

inline std::ostream& operator<<(std::ostream& out, const Cost& cost) {
  out << "{\"ns\":" << cost.ns << ",\"cpu_ns\":" << cost.cpu_ns << ",\"energy_uj\":";
  if (cost.energy_uj) return out << *cost.energy_uj << "}";
  return out << "null}";
}

// Microjoules that all processor packages have taken so far.
inline std::optional<double> energy_counters_uj() {
  namespace fs = std::filesystem;
  std::error_code error;
  std::optional<double> sum;
  for (const auto& entry : fs::directory_iterator("/sys/class/powercap", error)) {
    const std::string name = entry.path().filename();
    if (name.rfind("intel-rapl:", 0) != 0 || name.find(':', 11) != std::string::npos) continue;
    double uj = 0;
    if (!(std::ifstream(entry.path() / "energy_uj") >> uj)) return std::nullopt;
    sum = sum.value_or(0) + uj;
  }
  return sum;
}

// What the processor has spent on this process.
inline uint64_t cpu_ns() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<uint64_t>(time.tv_sec) * 1000000000 + static_cast<uint64_t>(time.tv_nsec);
}

template <typename Work>
Cost measure(int runs, Work&& work) {
  using Clock = std::chrono::steady_clock;
  Cost cost{UINT64_MAX, UINT64_MAX, std::nullopt};
  for (int run = 0; run < std::max(runs, 1); ++run) {
    const auto start = Clock::now();
    const uint64_t cpu_start = cpu_ns();
    work();
    cost.cpu_ns = std::min(cost.cpu_ns, cpu_ns() - cpu_start);
    const uint64_t ns = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start).count();
    cost.ns = std::min(cost.ns, ns);
  }
  const auto before = runs > 1 ? energy_counters_uj() : std::nullopt;
  if (!before) return cost;
  const auto start = Clock::now();
  int count = 0;
  for (; Clock::now() - start < std::chrono::milliseconds(400); ++count) work();
  const double spent = *energy_counters_uj() - *before;
  if (spent > 0) cost.energy_uj = spent / count;
  return cost;
}

struct Point {
  float x, y, z, intensity;
};

// KITTI's files: four little-endian floats a point. A point at the origin is no return, and left out.
inline std::vector<Point> read_cloud(const char* path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw std::runtime_error(std::string(path) + ": cannot be read");
  std::vector<Point> points(static_cast<size_t>(in.tellg()) / sizeof(Point));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(points.data()), static_cast<std::streamsize>(points.size() * sizeof(Point)));
  const auto is_none = [](const Point& point) { return point.x == 0 && point.y == 0 && point.z == 0; };
  points.erase(std::remove_if(points.begin(), points.end(), is_none), points.end());
  return points;
}

inline void write_cloud(const char* path, const std::vector<Point>& points) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(points.data()), static_cast<std::streamsize>(points.size() * sizeof(Point)));
  if (!out) throw std::runtime_error(std::string(path) + ": cannot be written");
}

inline void print_codec(size_t bytes, const Cost& encode, const Cost& decode) {
  std::cout << "{\"bytes\":" << bytes << ",\"encode\":" << encode << ",\"decode\":" << decode << "}\n";
}
