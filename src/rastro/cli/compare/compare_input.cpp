// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/compare_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <set>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/simulated_worlds.h"
#include "rastro/math/median.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

bool is_world_name(const std::string& name) {
  const auto& worlds = simulated_worlds();
  return std::any_of(worlds.begin(), worlds.end(), [&](const SimulatedWorld& world) { return world.name == name; });
}

/// The recording as given, or below the folder of recordings; empty: neither is there.
std::string found_path(const std::string& name, const std::string& data_folder) {
  std::error_code ignored;
  for (const fs::path& path : {fs::path(name), fs::path(data_folder) / name})
    if (fs::exists(path, ignored)) return fs::canonical(path).string();
  return "";
}

/// Of what is not the name of a world: what such a world was simulated into often has its name.
std::string found_recording(const std::string& name, const std::string& data_folder) {
  std::string path = found_path(name, data_folder);
  if (path.empty() || !is_world_name(name)) return path;
  log_warning(fmt::format("{}: is taken as the world; for the recording of this name, give {}", name, path));
  return "";
}

/// "kitchen --intrinsics 1,2,3,4": the part before the flags, which may hold spaces, and the flags.
std::pair<std::string, std::vector<std::string>> name_and_flags(const std::string& text) {
  const std::size_t flags = text.find(" --");
  std::pair<std::string, std::vector<std::string>> parts{std::string(trim(text.substr(0, flags))), {}};
  if (flags == std::string::npos) return parts;
  for (const std::string_view word : split_words(std::string_view(text).substr(flags))) parts.second.emplace_back(word);
  return parts;
}

/// Takes `flag VALUE` or `flag=VALUE` out of the words; empty where it is not there.
std::string taken_from(std::vector<std::string>& words, const std::string& flag) {
  const auto is_joined = [&](const std::string& word) { return word.starts_with(flag + "="); };
  if (const auto joined = std::find_if(words.begin(), words.end(), is_joined); joined != words.end()) {
    const std::string value = joined->substr(flag.size() + 1);
    words.erase(joined);
    return value;
  }
  const auto found = std::find(words.begin(), words.end(), flag);
  if (found == words.end() || found + 1 == words.end()) return "";
  const std::string value = *(found + 1);
  words.erase(found, found + 2);
  return value;
}

/// --frames of a world is a number for 'rastro simulate'; of A:B, as recordings have it, B frames are simulated and the
/// runs read the rest.
void take_range_of_world(std::vector<std::string>& flags, CompareInput& input) {
  std::vector<std::string> others = flags;
  const std::string range = taken_from(others, "--frames");
  if (range.find(':') == std::string::npos) return;
  OpenOptions chosen;
  const std::int64_t open_end = chosen.end_frame;
  set_frames(range, chosen);
  flags = std::move(others);
  input.input.frames = range;
  if (chosen.end_frame != open_end) flags.insert(flags.end(), {"--frames", std::to_string(chosen.end_frame)});
}

std::vector<double> speeds_of(const Trajectory& poses) {
  std::vector<double> speeds;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double seconds = to_seconds(poses[k].stamp - poses[k - 1].stamp);
    const double meters = (poses[k].world_from_body.translation() - poses[k - 1].world_from_body.translation()).norm();
    if (seconds > 0.0) speeds.push_back(meters / seconds);
  }
  return speeds;
}

double path_of(const Trajectory& poses) {
  double meters = 0.0;
  for (std::size_t k = 1; k < poses.size(); ++k)
    meters += (poses[k].world_from_body.translation() - poses[k - 1].world_from_body.translation()).norm();
  return meters;
}

}  // namespace

bool is_seed(const std::string& word) { return word == "--seed" || word.starts_with("--seed="); }

CompareInput parse_compare_input(const std::string& text, const InputDefaults& defaults) {
  auto [name, flags] = name_and_flags(text);
  CompareInput input;
  const std::string recording = found_recording(name, defaults.data_folder);
  if (recording.empty() && !is_world_name(name)) {
    std::vector<std::string> worlds;
    for (const SimulatedWorld& world : simulated_worlds()) worlds.emplace_back(world.name);
    throw Error("is neither a recording nor a world", name,
                did_you_mean(name, worlds,
                             fmt::format("give a path, a name below {}, or a world: {}", defaults.data_folder,
                                         fmt::join(worlds, ", "))));
  }
  input.input.frames = defaults.frames;
  if (recording.empty()) {
    input.input.world = input.name = name;
    if (std::any_of(flags.begin(), flags.end(), is_seed))
      throw Error("seeds of worlds are chosen for all of them", name, "give --seeds N to compare: seeds 1 to N");
    take_range_of_world(flags, input);
    input.input.simulate = flags;
    for (std::uint64_t seed = 1; seed <= defaults.seeds; ++seed) input.seeds.push_back(seed);
    return input;
  }
  input.input.data = recording;
  input.name = fs::path(recording).filename().string();
  if (const std::string frames = taken_from(flags, "--frames"); !frames.empty()) input.input.frames = frames;
  input.flags = defaults.flags;
  input.flags.insert(input.flags.end(), flags.begin(), flags.end());
  return input;
}

std::vector<CompareInput> parse_compare_inputs(const std::vector<std::string>& texts, const InputDefaults& defaults) {
  std::vector<CompareInput> inputs;
  std::set<std::string> names;
  for (const std::string& text : texts) {
    inputs.push_back(parse_compare_input(text, defaults));
    const std::string name = inputs.back().name;
    for (int k = 2; !names.insert(inputs.back().name).second; ++k) inputs.back().name = fmt::format("{} ({})", name, k);
  }
  return inputs;
}

OpenOptions open_options_of(const std::string& path, const std::vector<std::string>& words) {
  CLI::App app;
  DataFlags flags;
  add_data_flags(app, flags);
  app.allow_extras();
  std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 wants them
  reversed.push_back(path);
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    throw Error(one_line(error.what()), path, "correct the flags of this input");
  }
  return open_options(flags);
}

InputFacts facts_of(const SourceInfo& info, const std::optional<StampSpan>& span) {
  InputFacts facts;
  facts.has_image = info.has_image;
  facts.has_right = info.has_right, facts.has_depth = info.has_depth;
  facts.has_scan = info.has_scan, facts.has_odometry = info.has_odometry;
  facts.frames = info.frame_count;
  facts.has_ground_truth = !info.ground_truth.empty();
  if (!facts.has_ground_truth) return facts;
  Trajectory poses = info.ground_truth;
  if (span)
    std::erase_if(poses, [&](const StampedPose& pose) { return pose.stamp < span->first || pose.stamp > span->last; });
  facts.path_m = path_of(poses);
  const std::vector<double> speeds = speeds_of(poses);
  if (!speeds.empty()) facts.speed_m_s = median(speeds);
  return facts;
}

}  // namespace rastro::cli
