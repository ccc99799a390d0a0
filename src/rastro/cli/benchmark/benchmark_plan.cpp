// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/hash.h"
#include "rastro/cli/benchmark/file_states.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

void append(std::vector<std::string>& words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
}

void append_each(std::vector<std::string>& words, const std::string& flag, const std::vector<std::string>& values) {
  for (const std::string& value : values) append(words, {flag, value});
}

bool begins_at_first_frame(const std::string& frames) {
  return frames.empty() || frames.starts_with(':') || frames.starts_with("0:");
}

/// The path of a recording, and of the part that makes it where it is simulated.
struct PlannedInput {
  std::string path, part, ground_truth;
};

class Planner {
 public:
  explicit Planner(const fs::path& data_folder) : data_folder_(data_folder) {}

  void add(const BenchmarkEntry& entry) {
    for (const std::uint64_t seed : entry.seeds.empty() ? std::vector<std::uint64_t>{0} : entry.seeds)
      plan_.runs.push_back(run_of(entry, seed));
  }

  BenchmarkPlan finish() {
    // A simulated recording that is not kept is removed behind its last run.
    std::map<std::string, std::size_t> first_use;
    for (std::size_t k = 0; k < plan_.runs.size(); ++k) first_use.emplace(plan_.runs[k].recording, k);
    std::stable_sort(plan_.runs.begin(), plan_.runs.end(), [&](const BenchmarkRun& a, const BenchmarkRun& b) {
      return first_use.at(a.recording) < first_use.at(b.recording);
    });
    return std::move(plan_);
  }

 private:
  BenchmarkRun run_of(const BenchmarkEntry& entry, std::uint64_t seed) {
    BenchmarkRun run;
    run.entry = entry.name;
    run.seed = seed;
    run.may_refuse = !entry.disturbances.empty() || entry.expect == Expectation::lost;
    run.id = as_file_name(entry.input.world.empty() ? entry.name : fmt::format("{} seed {}", entry.name, seed));
    const PlannedInput input = entry.input.as_scan ? scan_of(entry, seed) : input_of(entry.input, seed);
    run.recording = input.part;
    run.judgment = {.ground_truth = input.ground_truth,
                    .alignment = entry.alignment,
                    .false_pose_limit_m = entry.false_pose_limit_m,
                    .measures_map = begins_at_first_frame(entry.input.frames) && entry.disturbances.empty(),
                    .localized = entry.map.has_value(),
                    .same_world = !entry.map || entry.map->same_world,
                    .map_ground_truth = {}};
    if (!entry.has_ground_truth) run.judgment.ground_truth.clear();
    if (!entry.ground_truth.empty()) run.judgment.ground_truth = existing(entry.ground_truth);
    run.words = {entry.map ? "localize" : entry.method.command, input.path};
    if (entry.map)
      add_map(entry, seed, run);
    else
      append(run.words, {"--method", entry.method.method});
    append_settings(entry.method, entry.input.as_scan ? "" : entry.input.frames, run.words);
    append_each(run.words, "--disturb", entry.disturbances);
    run.files = files_of(run);
    return run;
  }

  void add_part(BenchmarkPart part) {
    part.files = states_.of(part.words);
    if (!part.needs.empty()) part.files += plan_.parts.at(part.needs).files;
    plan_.parts.emplace(part.folder, std::move(part));
  }

  std::string files_of(const BenchmarkRun& run) {
    std::vector<std::string> words = run.words;
    append(words, {run.judgment.ground_truth, run.judgment.map_ground_truth});
    std::string files = states_.of(words);
    for (const std::string& part : {run.recording, run.map})
      if (!part.empty()) files += plan_.parts.at(part).files;
    return files;
  }

  void append_settings(const BenchmarkMethod& method, const std::string& frames, std::vector<std::string>& words) {
    if (!frames.empty()) append(words, {"--frames", frames});
    if (!method.sensor.empty()) append(words, {"--set", "sensor=" + method.sensor});
    append_each(words, "--set", method.settings);
    append(words, method.flags);
  }

  void add_map(const BenchmarkEntry& entry, std::uint64_t seed, BenchmarkRun& run) {
    const PlannedInput input = input_of(entry.map->input, seed);
    BenchmarkPart part;
    part.words = {"slam", input.path, "--method", entry.method.method};
    BenchmarkMethod method = entry.method;
    method.settings = entry.map->settings;
    method.flags = entry.map->flags;
    append_settings(method, entry.map->input.frames, part.words);
    part.needs = input.part;
    part.folder = "maps/" + as_file_name(fmt::format("{}", fmt::join(part.words, " ")));
    run.map = part.folder;
    run.judgment.map_ground_truth = input.ground_truth;
    append(run.words, {"--map", below_out + part.folder});
    add_part(part);
  }

  PlannedInput input_of(const BenchmarkInput& input, std::uint64_t seed) {
    if (input.world.empty()) {
      const std::string path = existing(input.data);
      return {path, "", path};
    }
    BenchmarkPart part;
    part.words = {"simulate", input.world, "--seed", std::to_string(seed)};
    append(part.words, input.simulate);
    part.folder = "worlds/" + as_file_name(fmt::format("{}", fmt::join(part.words.begin() + 1, part.words.end(), " ")));
    add_part(part);
    const std::string path = below_out + part.folder;
    return {path, part.folder, path};
  }

  /// The laser log cut out of the depth images; judged by the poses of the camera.
  PlannedInput scan_of(const BenchmarkEntry& entry, std::uint64_t seed) {
    const PlannedInput camera = input_of(entry.input, seed);
    BenchmarkPart part;
    part.words = {"convert", camera.path, "--to", "scan"};
    if (!entry.input.frames.empty()) append(part.words, {"--frames", entry.input.frames});
    append(part.words, entry.input.camera_flags);
    part.needs = camera.part;
    part.folder = "scans/" + as_file_name(fmt::format("{}", fmt::join(part.words, " "))) + ".log";
    add_part(part);
    return {below_out + part.folder, part.folder, camera.ground_truth};
  }

  std::string existing(const std::string& data) const {
    const fs::path path = fs::path(data).is_absolute() ? fs::path(data) : data_folder_ / data;
    std::error_code ignored;
    if (!fs::exists(path, ignored))
      throw Error("no such recording", path.string(),
                  "give --data DIR, the folder that holds the recordings of the list");
    return fs::canonical(path).string();
  }

  fs::path data_folder_;
  FileStates states_;
  BenchmarkPlan plan_;
};

}  // namespace

std::string resolved(const std::string& word, const fs::path& out) {
  return word.starts_with(below_out) ? (out / word.substr(std::string_view(below_out).size())).string() : word;
}

std::string as_file_name(const std::string& text) {
  constexpr std::size_t longest = 80, hash_digits = 8;
  std::string name;
  for (const char c : text) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
    name += plain ? c : '_';
  }
  if (name == text && name.size() <= longest && !name.starts_with('.')) return name;
  Sha256 hash;
  hash.add(text);
  return name.substr(0, longest) + "-" + hash.finish().substr(0, hash_digits);
}

std::string BenchmarkPlan::command_of(const BenchmarkRun& run) const {
  std::string text = fmt::format("{}", fmt::join(run.words, " "));
  std::vector<std::string> needed = {run.recording, run.map};
  for (std::size_t k = 0; k < needed.size(); ++k) {
    if (needed[k].empty()) continue;
    const BenchmarkPart& part = parts.at(needed[k]);
    text += fmt::format("; {}", fmt::join(part.words, " "));
    needed.push_back(part.needs);
  }
  const BenchmarkJudgment& judged = run.judgment;
  return text + fmt::format("; judged by {}, {}, {} m{}{}", judged.ground_truth,
                            judged.alignment.empty() ? "alignment as claimed" : judged.alignment,
                            judged.false_pose_limit_m,
                            judged.localized ? " in the map of " + judged.map_ground_truth : "",
                            judged.same_world ? "" : ", another world");
}

BenchmarkPlan plan_benchmark(const BenchmarkList& list, const fs::path& data_folder) {
  Planner planner(data_folder);
  for (const BenchmarkEntry& entry : list.entries) planner.add(entry);
  return planner.finish();
}

}  // namespace rastro::cli
