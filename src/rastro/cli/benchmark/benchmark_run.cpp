// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

fs::path result_file(const BenchmarkSetup& setup, const BenchmarkRun& run) {
  return setup.out / "results" / (run.id + ".json");
}

BenchmarkJudgment resolved_judgment(BenchmarkJudgment judgment, const fs::path& out) {
  judgment.ground_truth = resolved(judgment.ground_truth, out);
  judgment.map_ground_truth = resolved(judgment.map_ground_truth, out);
  return judgment;
}

/// Runs the missing runs of a plan, several at a time.
class Workers {
 public:
  Workers(const BenchmarkPlan& plan, const ResumedBenchmark& resumed, const BenchmarkSetup& setup,
          const BenchmarkTools& tools)
      : plan_(plan),
        missing_(resumed.missing),
        setup_(setup),
        tools_(tools),
        parts_(plan, resumed.missing, setup.out, setup.program, setup.keep, tools.run),
        results_(resumed.results) {}

  std::vector<BenchmarkResult> run_all() {
    std::vector<std::thread> threads;
    const int count = std::min(setup_.jobs, static_cast<int>(missing_.size()));
    try {
      for (int k = 1; k < count; ++k) threads.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      // The system allows no more threads: fewer runs at a time.
    }
    work();
    for (std::thread& thread : threads) thread.join();
    if (failure_) std::rethrow_exception(failure_);
    return std::move(results_);
  }

 private:
  bool is_over() const { return failed_ || (tools_.stop != nullptr && *tools_.stop); }

  void work() {
    try {
      for (std::size_t k = next_++; k < missing_.size() && !is_over(); k = next_++) finish(*missing_[k]);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failed_.exchange(true)) failure_ = std::current_exception();
    }
  }

  /// Runs it and keeps its result, unless it was stopped. A run that could not start counts as failed, but only in this
  /// call: what it needs may be made the next time.
  void finish(const BenchmarkRun& run) {
    const std::string missing_part = parts_.need(run);
    std::optional<BenchmarkResult> result;
    if (!is_over()) result = missing_part.empty() ? result_of(run) : failed_before(run, missing_part);
    parts_.release(run);
    if (!result) return;
    if (missing_part.empty()) write_whole_file(result_file(setup_, run), to_json(*result));
    const std::lock_guard lock(mutex_);
    results_.push_back(*result);
    if (tools_.progress) tools_.progress(*result, ++done_, static_cast<int>(missing_.size()));
  }

  BenchmarkResult new_result(const BenchmarkRun& run) const {
    BenchmarkResult result;
    result.entry = run.entry, result.seed = run.seed;
    result.command = plan_.command_of(run), result.program = setup_.program;
    result.files = run.files;
    result.jobs = setup_.jobs, result.threads = setup_.threads;
    return result;
  }

  BenchmarkResult failed_before(const BenchmarkRun& run, const std::string& failure) const {
    std::error_code ignored;
    fs::remove(result_file(setup_, run), ignored);
    BenchmarkResult result = new_result(run);
    result.failure = failure;
    return result;
  }

  std::optional<BenchmarkResult> result_of(const BenchmarkRun& run) {
    BenchmarkResult result = new_result(run);
    const fs::path folder = setup_.out / "runs" / run.id;
    const ChildEnd end = tools_.run(words_of(run, folder));
    if (end.stopped) return std::nullopt;
    result.wall_s = end.wall_s, result.cpu_s = end.cpu_s, result.peak_memory_mb = end.peak_memory_mb;
    result.message = end.last_line;
    result.failure = failure_of(end);
    result.timed_out = end.timed_out;
    if (result.failure.empty()) {
      judge(run, folder, result);
    } else if (run.may_refuse && end.exit_code == refused) {
      result.failure.clear();
      result.scores.warned = true;
    }
    std::error_code ignored;
    if (!setup_.keep) fs::remove_all(folder, ignored);
    return result;
  }

  std::vector<std::string> words_of(const BenchmarkRun& run, const fs::path& folder) const {
    std::vector<std::string> words;
    for (const std::string& word : run.words) words.push_back(resolved(word, setup_.out));
    words.insert(words.end(), {"--out", folder.string(), "--force", "--quiet"});
    if (setup_.threads > 0) words.insert(words.end(), {"--threads", std::to_string(setup_.threads)});
    return words;
  }

  void judge(const BenchmarkRun& run, const fs::path& folder, BenchmarkResult& result) const {
    try {
      const fs::path map_folder = run.map.empty() ? fs::path() : setup_.out / run.map;
      result.scores = tools_.score(folder, resolved_judgment(run.judgment, setup_.out), map_folder);
    } catch (const Error& error) {
      result.failure = fmt::format("cannot be judged: {}", error.what());
    }
  }

  static constexpr int refused = 2;  ///< Exit code of the program for unusable input.

  const BenchmarkPlan& plan_;
  const std::vector<const BenchmarkRun*>& missing_;
  const BenchmarkSetup& setup_;
  const BenchmarkTools& tools_;
  BenchmarkParts parts_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> failed_ = false;
  std::mutex mutex_;  ///< Guards what follows.
  std::vector<BenchmarkResult> results_;
  std::exception_ptr failure_;
  int done_ = 0;
};

using Count = int ResumedBenchmark::*;

/// Where a run counts that has a former result but is run again; null: the result holds.
Count reason_to_run(const BenchmarkPlan& plan, const BenchmarkRun& run, const BenchmarkSetup& setup,
                    const BenchmarkResult& former) {
  constexpr double most_of_a_wait = 1.1;  // until a run is stopped, it takes somewhat longer than its limit
  if (former.command != plan.command_of(run)) return &ResumedBenchmark::other_command;
  if (former.program != setup.program) return &ResumedBenchmark::other_program;
  if (former.files != run.files) return &ResumedBenchmark::other_files;
  if (former.jobs != setup.jobs || former.threads != setup.threads) return &ResumedBenchmark::other_load;
  if (former.timed_out && setup.timeout_s > most_of_a_wait * former.wall_s) return &ResumedBenchmark::more_time;
  return nullptr;
}

}  // namespace

std::string ResumedBenchmark::text() const {
  std::string text = fmt::format("{} of {} runs have results", results.size(), results.size() + missing.size());
  if (other_command > 0) text += fmt::format("; {} run again: the list changed", other_command);
  if (more_time > 0) text += fmt::format("; {} run again: they have more time now", more_time);
  if (other_program > 0) text += fmt::format("; {} run again: the program changed", other_program);
  if (other_files > 0) text += fmt::format("; {} run again: files that they read changed", other_files);
  if (other_load > 0) text += fmt::format("; {} run again: with other --jobs or --threads", other_load);
  return text;
}

ResumedBenchmark resume_benchmark(const BenchmarkPlan& plan, const BenchmarkSetup& setup) {
  ResumedBenchmark resumed;
  for (const BenchmarkRun& run : plan.runs) {
    const auto former = setup.force ? std::nullopt : read_benchmark_result(result_file(setup, run));
    const Count reason = former ? reason_to_run(plan, run, setup, *former) : nullptr;
    if (former && reason == nullptr) {
      resumed.results.push_back(*former);
      continue;
    }
    resumed.missing.push_back(&run);
    if (reason != nullptr) ++(resumed.*reason);
  }
  return resumed;
}

void make_result_folders(const fs::path& out) {
  for (const char* folder : {"results", "runs"}) {
    std::error_code error;
    fs::create_directories(out / folder, error);
    if (error) throw Error("cannot be created: " + error.message(), (out / folder).string(), "choose another --out");
  }
}

void forget_results(const BenchmarkPlan& plan, const BenchmarkSetup& setup) {
  std::error_code ignored;
  for (const BenchmarkRun& run : plan.runs) fs::remove(result_file(setup, run), ignored);
}

std::vector<BenchmarkResult> run_missing(const BenchmarkPlan& plan, const ResumedBenchmark& resumed,
                                         const BenchmarkSetup& setup, const BenchmarkTools& tools) {
  make_result_folders(setup.out);
  return Workers(plan, resumed, setup, tools).run_all();
}

}  // namespace rastro::cli
