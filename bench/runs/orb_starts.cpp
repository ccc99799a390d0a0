// SPDX-License-Identifier: Apache-2.0
// Map initialization of one camera on twenty generated starts, compared with ground truth:
//   rastro_bench_orb_starts [--set name=value]...
#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "rastro/base/error.h"
#include "rastro/methods/methods.h"
#include "tests/contract/start_judgment.h"

namespace {

using namespace rastro;

void run(int argc, char** argv) {
  const auto method = slam_method("orb");
  OptionTable table = method->options();
  table.set("sensor", "mono", "rastro_bench_orb_starts");
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) != "--set" || i + 1 == argc)
      throw Error("this is not an option", argv[i], "give --set name=value, or nothing");
    table.set_assignment(argv[++i], "--set");
  }
  TaskPool pool(0);
  int wrong = 0, started = 0;
  fmt::print("{:15} {:>7} {:>6} {:>9} {:>9} {:>9} {:>9} {:>8}\n", "start", "frame", "poses", "landmarks", "path m",
             "position", "rotation", "depth");
  for (const StartKind kind : start_kinds)
    for (int variation = 0; variation < start_variations; ++variation) {
      const World world = make_start(kind, variation);
      const StartJudgment judged = judge_start(world, *method, pool);
      const std::string name = fmt::format("{} {}", name_of(kind), variation + 1);
      if (!judged.started) {
        fmt::print("{:15}   never: {}\n", name, judged.waiting);
        continue;
      }
      ++started;
      wrong += judged.never_wrong() ? 0 : 1;
      fmt::print("{:15} {:>7} {:>6} {:>9} {:>9.2f} {:>8.2f}% {:>6.2f}deg {:>7.2f}%{}\n", name, *judged.started,
                 judged.poses, judged.landmarks, judged.path_m, 100.0 * judged.position_error,
                 judged.rotation_error_rad * 57.2958, 100.0 * judged.depth_error,
                 judged.never_wrong() ? "" : "  WRONG");
    }
  fmt::print("{} initialized, {} wrong\n", started, wrong);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc, argv);
  } catch (const rastro::Error& error) {
    std::fprintf(stderr, "rastro_bench_orb_starts: %s\n", error.what());
    return 2;
  }
  return 0;
}
