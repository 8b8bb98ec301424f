// SPDX-License-Identifier: MIT
// Time and memory of `alidade fleet` on a random fleet, with a previous calibration of each unit.
//
// usage: fleet_bench PROGRAM FOLDER [UNITS]
//
// Writes UNITS camera files (default 10000) to FOLDER/now, one in a hundred of them damaged, and as many to
// FOLDER/before, unless they exist; then runs PROGRAM on them. Exit code 1: it takes longer than 120 s or
// more than 1 GB.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "alidade/core/parallel.h"
#include "alidade/files/camera_save.h"
#include "support/drawn_fleet.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

void writeUnits(const fs::path& folder, std::size_t count) {
  const CameraPopulation population;
  fs::create_directories(folder / "now");
  fs::create_directories(folder / "before");
  parallelFor(count, 0, [&](std::size_t i) {
    const std::string name = "unit" + std::to_string(i) + ".yaml";
    if (fs::exists(folder / "before" / name)) return;
    Random random(streamSeed(1, i));
    const Eigen::VectorXd unit = population.drawUnit(random);
    constexpr std::size_t kEachDrifted = 50;
    const bool is_drifted = i % kEachDrifted == 0;
    const Eigen::VectorXd now = is_drifted ? withFocalError(unit, population.size(), 1) : unit;
    saveCamera((folder / "now" / name).string(),
               population.calibrated(now, random.uniform(0.05, 0.2), random), "alidade");
    saveCamera((folder / "before" / name).string(), population.calibrated(unit, 0.1, random), "alidade");
    constexpr std::size_t kEachDamaged = 100;
    if (i % kEachDamaged == 99) std::ofstream(folder / "now" / name) << "alidade_camera: 1\nmodel: radtan\n";
  });
}

// Seconds and largest resident memory of a shell command.
struct RunCost {
  double seconds = 0;
  double cpu_seconds = 0;  // sum over all threads
  double megabytes = 0;
  int exit_code = 0;
};

double secondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

RunCost costOf(const std::string& command) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  return {.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          .cpu_seconds = secondsOf(usage.ru_utime) + secondsOf(usage.ru_stime),
          .megabytes = static_cast<double>(usage.ru_maxrss) / 1024,
          .exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 127};
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: fleet_bench PROGRAM FOLDER [UNITS]\n");
    return 2;
  }
  const std::string program = argv[1];
  const std::filesystem::path folder = argv[2];
  const auto count = static_cast<std::size_t>(argc > 3 ? std::atol(argv[3]) : 10000);
  alidade::writeUnits(folder, count);
  bool is_good = true;
  const std::string now = (folder / "now").string();
  for (const std::string& more : {std::string(), " --previous " + (folder / "before").string()}) {
    const alidade::RunCost cost = alidade::costOf("exec " + program + " fleet " + now + more + " -o " +
                                                  (folder / "fleet.html").string() + " --quiet");
    std::printf("%zu files%s: %.1f s (%.1f s of processors), %.0f MB, exit code %d\n", count,
                more.empty() ? "" : " with previous ones", cost.seconds, cost.cpu_seconds, cost.megabytes,
                cost.exit_code);
    is_good = is_good && cost.exit_code == 0 && cost.seconds <= 120 && cost.megabytes <= 1024;
  }
  return is_good ? 0 : 1;
}
