// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_list.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/dataset/open.h"

namespace rastro::cli {

/// What an input holds and how its sensor moves; decides which methods can run and which use case it stands for.
struct InputFacts {
  bool has_image = false, has_color = false, has_right = false, has_depth = false, has_scan = false;
  bool has_odometry = false, has_ground_truth = false;
  std::int64_t frames = 0;  ///< The chosen ones; -1 if unknown.
  double rate_hz = 0.0;     ///< Of the frames; 0 if unknown.
  double path_m = 0.0;      ///< Of the ground truth at the chosen frames; 0 without.
  double speed_m_s = 0.0;   ///< Median along it; 0 without.
};

/// One input of a comparison: a recording or a simulated world.
struct CompareInput {
  std::string name;  ///< Short and unique, as in tables.
  BenchmarkInput input;
  std::vector<std::string> flags;    ///< Further words of every run on it, such as --intrinsics.
  std::vector<std::uint64_t> seeds;  ///< Of the world; empty for a recording.
  InputFacts facts;
  bool is_special = false;  ///< Wrong on purpose, or localized in a map: no example of a use case.

  bool is_world() const { return !input.world.empty(); }
  /// That every run reads, as --frames; empty: all. Also of a world, whose own flags say how many are simulated.
  const std::string& frames() const { return input.frames; }
};

/// What all inputs have in common.
struct InputDefaults {
  std::string frames;              ///< --frames; empty: all.
  std::vector<std::string> flags;  ///< Of every run on a recording.
  std::uint64_t seeds = 1;         ///< Of a world: 1 to this.
  std::string data_folder;         ///< What recordings that are not found as given are relative to.
};

/// One word of the command line: a recording or world, with flags behind it: "bedroom --frames 60" passes them to
/// 'rastro simulate', "kitchen --intrinsics 585,585,320,240" to every run. "bedroom --frames 20:60" simulates 60 frames
/// and every run reads frames 20 to 59. The bare name of a world is the world, also
/// where a file or folder has that name. Error for what is neither.
CompareInput parse_compare_input(const std::string& text, const InputDefaults& defaults);

/// The same for several, with unique names.
std::vector<CompareInput> parse_compare_inputs(const std::vector<std::string>& texts, const InputDefaults& defaults);

/// How to open a recording that a run with these further words reads; words that are no flags of the input are
/// ignored. Error for wrong values.
OpenOptions open_options_of(const std::string& path, const std::vector<std::string>& words);

/// Of the opened recording; of its ground truth only what lies in the span, where one is given.
InputFacts facts_of(const SourceInfo& info, const std::optional<StampSpan>& span);

}  // namespace rastro::cli
