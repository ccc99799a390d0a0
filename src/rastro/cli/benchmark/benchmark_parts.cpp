// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

bool holds(const fs::path& file, const std::string& text) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && read_whole_file(file) == text;
}

}  // namespace

std::string failure_of(const ChildEnd& end) {
  if (end.timed_out) return "took too long and was stopped";
  if (end.signal != 0) return fmt::format("crashed by signal {}: {}", end.signal, end.last_line);
  if (end.exit_code != 0 && end.exit_code != 1) return fmt::format("exit code {}: {}", end.exit_code, end.last_line);
  return "";
}

BenchmarkParts::BenchmarkParts(const BenchmarkPlan& plan, const std::vector<const BenchmarkRun*>& runs, fs::path out,
                               std::string program, bool keep, RunProgram run_program)
    : plan_(plan),
      out_(std::move(out)),
      program_(std::move(program)),
      keep_(keep),
      run_program_(std::move(run_program)) {
  for (const BenchmarkRun* run : runs)
    for (const std::string& folder : folders_of(*run)) ++states_[folder].uses;
}

std::vector<std::string> BenchmarkParts::folders_of(const BenchmarkRun& run) const {
  std::vector<std::string> folders;
  for (const std::string& part : {run.recording, run.map}) {
    if (part.empty()) continue;
    if (const std::string& needed = plan_.parts.at(part).needs; !needed.empty()) folders.push_back(needed);
    folders.push_back(part);
  }
  return folders;
}

std::string BenchmarkParts::need(const BenchmarkRun& run) {
  for (const std::string& folder : folders_of(run))
    if (const std::string failure = need(folder); !failure.empty()) return failure;
  return "";
}

std::string BenchmarkParts::need(const std::string& folder) {
  State& state = states_.at(folder);
  const std::lock_guard lock(state.making);
  if (state.made) return state.failure;
  const BenchmarkPart& part = plan_.parts.at(folder);
  if (!holds(mark_file(folder), mark_of(part))) state.failure = make(part);
  state.made = true;
  return state.failure;
}

std::string BenchmarkParts::mark_of(const BenchmarkPart& part) const {
  const bool is_map = part.words.front() != "simulate";
  return fmt::format("{}{}{}\n", fmt::join(part.words, " "), part.files, is_map ? "; program " + program_ : "");
}

std::string BenchmarkParts::make(const BenchmarkPart& part) {
  std::error_code ignored;
  fs::remove(mark_file(part.folder), ignored);
  fs::remove_all(out_ / part.folder, ignored);
  std::error_code code;
  const fs::path folder = (out_ / part.folder).parent_path();
  fs::create_directories(folder, code);
  if (code) throw Error("cannot be made (" + code.message() + ")", folder.string(), "choose another --out");
  std::vector<std::string> words;
  for (const std::string& word : part.words) words.push_back(resolved(word, out_));
  words.insert(words.end(), {"--out", (out_ / part.folder).string(), "--quiet"});
  const ChildEnd end = run_program_(words);
  if (end.stopped) return "stopped";
  const std::string failure = failure_of(end);
  if (!failure.empty()) return fmt::format("'{}' failed: {}", fmt::join(part.words, " "), failure);
  write_whole_file(mark_file(part.folder), mark_of(part));
  return "";
}

void BenchmarkParts::release(const BenchmarkRun& run) {
  for (const std::string& folder : folders_of(run)) {
    State& state = states_.at(folder);
    const std::lock_guard lock(state.making);
    if (--state.uses > 0 || keep_) continue;
    std::error_code ignored;
    fs::remove(mark_file(folder), ignored);
    fs::remove_all(out_ / folder, ignored);
  }
}

}  // namespace rastro::cli
