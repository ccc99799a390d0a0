// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace rastro::cli {

/// What a run reads: a recording, or a world simulated with a seed.
struct BenchmarkInput {
  std::string data;                       ///< As in the list; empty: `world`.
  std::string world;                      ///< As of 'rastro simulate'.
  std::vector<std::string> simulate;      ///< Further words of 'rastro simulate'.
  std::string frames;                     ///< "A:B"; empty: all.
  bool as_scan = false;                   ///< As a laser log, cut out of its depth images...
  std::vector<std::string> camera_flags;  ///< ... with these further words.
};

/// How a method runs on it.
struct BenchmarkMethod {
  std::string command = "slam";  ///< Or "odometry".
  std::string method;
  std::string sensor;                 ///< Option sensor; empty: not given.
  std::vector<std::string> settings;  ///< "key=value".
  std::vector<std::string> flags;     ///< Further words of the command.
};

/// Whether localization should find itself in a map.
enum class Expectation : std::uint8_t { none, found, lost };

/// A map to localize in.
struct BenchmarkMap {
  BenchmarkInput input;
  std::vector<std::string> settings, flags;
  bool same_world = true;  ///< The ground truths of map and run have one frame; false: every pose found is false.
};

/// One line of the table.
struct BenchmarkEntry {
  std::string name;
  BenchmarkInput input;
  std::vector<std::uint64_t> seeds;  ///< Of the world; empty for a recording.
  BenchmarkMethod method;
  std::vector<std::string> disturbances;  ///< NAME or NAME=VALUE; empty: none.
  std::optional<BenchmarkMap> map;        ///< Localization in it.
  Expectation expect = Expectation::none;
  bool has_ground_truth = true;  ///< False: poses are not judged.
  std::string ground_truth;      ///< Trajectory, or relations of a laser log; empty: that of the recording.
  std::string alignment;  ///< "se3", "sim3" or "yaw"; empty: yaw in a plane, else as the run claims, metric or not.
  double false_pose_limit_m = 0.1;  ///< A pose further than this from the ground truth is false.
};

/// How much worse than the baseline an entry may be before it is reported.
struct BenchmarkTolerance {
  double ate_percent = 5.0, ate_m = 0.001;
  double tracked_points = 1.0;  ///< Percentage points.
  double time_percent = 10.0, time_ms = 1.0;
  double memory_percent = 10.0, memory_mb = 5.0;
};

struct BenchmarkList {
  std::string file;
  std::vector<BenchmarkEntry> entries;  ///< Names are unique.
  double timeout_s = 3600.0;            ///< A run that takes longer is stopped and counts as failed.
  bool keep = true;                     ///< Simulated recordings, maps and run folders stay.
  BenchmarkTolerance tolerance;
};

/// Reads a list; docs/how-to/benchmark.md describes it. Error with file and line for anything wrong in it; an unknown
/// key is named with the nearest known one.
BenchmarkList read_benchmark_list(const std::string& file);
BenchmarkList parse_benchmark_list(const std::string& yaml, const std::string& file);

}  // namespace rastro::cli
