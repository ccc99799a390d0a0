// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/compare_flags.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"

namespace rastro::cli {
namespace {

/// The flags that every run on a recording gets.
std::vector<std::string> flags_of_recordings(const CompareFlags& flags) {
  std::vector<std::string> words;
  for (const auto& [flag, value] :
       std::vector<std::pair<std::string, std::string>>{{"--intrinsics", flags.intrinsics},
                                                        {"--calibration", flags.calibration},
                                                        {"--fov", flags.fov},
                                                        {"--rate", flags.rate},
                                                        {"--every", flags.every}})
    if (!value.empty()) words.insert(words.end(), {flag, value});
  return words;
}

/// One list of 'rastro benchmark' in place of inputs and methods.
bool is_list(const CompareFlags& flags) {
  const std::string extension = std::filesystem::path(flags.inputs.front()).extension().string();
  return flags.inputs.size() == 1 && (extension == ".yaml" || extension == ".yml");
}

/// What says which runs there are, where a list says that.
void refuse_beside_list(const CompareFlags& flags) {
  for (const auto& [flag, is_given] : std::vector<std::pair<std::string, bool>>{
           {"--methods", !flags.methods.empty()}, {"--seeds", flags.seeds_given}, {"--frames", !flags.frames.empty()}})
    if (is_given) throw Error("is not for a list", flag, "say it in the entries of " + flags.inputs.front());
  if (const auto words = flags_of_recordings(flags); !words.empty())
    throw Error("is not for a list", words.front(), "give it as 'flags' in the entries of " + flags.inputs.front());
}

BenchmarkList read_list(const CompareFlags& flags) {
  refuse_beside_list(flags);
  BenchmarkList list = read_benchmark_list(flags.inputs.front());
  if (!list.keep)
    log_warning(list.file + ": 'keep: no' is for 'rastro benchmark': the report is made of the runs, which stay");
  return list;
}

}  // namespace

SessionFlags session_of(const CompareFlags& flags, const CompareTask& task) {
  SessionFlags session = flags.session;
  if (task.list) session.timeout_s = task.list->timeout_s;
  session.timeout_s = flags.timeout_s.value_or(session.timeout_s);
  return session;
}

CompareTask task_of(const CompareFlags& flags, const std::string& data) {
  constexpr std::uint64_t most_seeds = 1000;
  if (flags.seeds < 1 || flags.seeds > most_seeds)
    throw Error(fmt::format("{} is not a number of worlds", flags.seeds), "--seeds", "give 1 to 1000");
  if (flags.repeats < 1 || flags.repeats > 1000)
    throw Error(fmt::format("{} is not a number of repeats", flags.repeats), "--repeat", "give 1 to 1000");
  CompareTask task;
  task.repeats = flags.repeats;
  task.quiet = flags.quiet;
  if (is_list(flags)) {
    task.list = read_list(flags);
    return task;
  }
  task.paper = flags.paper && flags.methods.empty();
  if (!task.paper && flags.methods.empty())
    throw Error("is required", "--methods", "give all, or names; 'rastro methods' lists them");
  task.inputs = parse_compare_inputs(flags.inputs, {flags.frames, flags_of_recordings(flags), flags.seeds, data});
  if (!task.paper) task.methods = methods_named(flags.methods);
  return task;
}

}  // namespace rastro::cli
