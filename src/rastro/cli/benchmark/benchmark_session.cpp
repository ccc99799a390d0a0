// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/hash.h"
#include "rastro/cli/benchmark/run_scores.h"
#include "rastro/cli/interrupt.h"

namespace rastro::cli {
namespace {

constexpr const char* this_program = "/proc/self/exe";

std::string hash_of_program() {
  std::ifstream program(this_program, std::ios::binary);
  Sha256 hash;
  std::vector<char> bytes(1 << 20);
  while (program.read(bytes.data(), static_cast<std::streamsize>(bytes.size())) || program.gcount() > 0)
    hash.add({bytes.data(), static_cast<std::size_t>(program.gcount())});
  return hash.finish();
}

void show(const BenchmarkResult& result, int done, int count) {
  const RunScores& scores = result.scores;
  const std::string seed = result.seed == 0 ? "" : fmt::format(" seed {}", result.seed);
  const std::string error = scores.ate_m ? fmt::format("{:.4f} m", *scores.ate_m) : "no error to measure";
  const std::string said =
      result.failure.empty()
          ? fmt::format("{}, {} of {} frames tracked, {} false, {:.1f} s{}", error, scores.tracked, scores.frames,
                        scores.false_poses + scores.false_poses_lost, result.wall_s, scores.warned ? ", warned" : "")
          : result.failure;
  fmt::print(stderr, "[{}/{}] {}{}: {}\n", done, count, result.entry, seed, said);
}

}  // namespace

std::shared_ptr<const FolderLock> claim_results(const std::filesystem::path& out) {
  make_result_folders(out);
  return std::make_shared<const FolderLock>(out);
}

BenchmarkSetup benchmark_setup(const SessionFlags& flags, bool keep) {
  constexpr double most_s = 1e7;
  if (flags.jobs < 1 || flags.jobs > 256)
    throw Error(fmt::format("{} is not a number of runs", flags.jobs), "--jobs", "give 1 to 256");
  if (flags.threads < 0)
    throw Error(fmt::format("{} is not a number of threads", flags.threads), "--threads", "give 1 or more, or 0");
  if (!(flags.timeout_s > 0.0 && flags.timeout_s <= most_s))
    throw Error(fmt::format("{} is not a time", flags.timeout_s), "--timeout", "give seconds, such as 600");
  if (flags.out.empty()) throw Error("is required", "--out", "give a folder: --out DIR");
  std::error_code ignored;
  if (std::filesystem::exists(flags.out, ignored) && !std::filesystem::is_directory(flags.out, ignored))
    throw Error("is a file", flags.out, "give a folder: --out DIR");
  BenchmarkSetup setup;
  setup.timeout_s = flags.timeout_s;
  setup.out = flags.out;
  setup.lock = claim_results(setup.out);
  setup.program = hash_of_program();
  setup.jobs = flags.jobs;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  setup.threads = flags.threads == 0 && flags.jobs > 1 ? std::max(1, cores / flags.jobs) : flags.threads;
  setup.keep = keep;
  setup.force = flags.force;
  return setup;
}

BenchmarkTools benchmark_tools(const BenchmarkSetup& setup, bool quiet) {
  const std::atomic<bool>& stop = catch_interrupts();
  BenchmarkTools tools;
  tools.stop = &stop;
  tools.run = [&stop, timeout_s = setup.timeout_s](const std::vector<std::string>& words) {
    std::vector<std::string> command = {"rastro"};
    command.insert(command.end(), words.begin(), words.end());
    return run_child(this_program, command, timeout_s, stop);
  };
  tools.score = score_run;
  if (!quiet) tools.progress = show;
  return tools;
}

std::string data_folder(const std::string& given) {
  const char* set = std::getenv("RASTRO_DATA");
  if (!given.empty()) return given;
  return set != nullptr && *set != '\0' ? set : "../shared/data";
}

}  // namespace rastro::cli
