// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_list.h"

namespace rastro::cli {

/// Paths in a plan that begin with this are below the output folder, so that it may be moved.
constexpr const char* below_out = "@out/";
/// The path or word with `out` in place of the mark.
std::string resolved(const std::string& word, const std::filesystem::path& out);

/// A simulated recording or a map that several runs use and that is made once.
struct BenchmarkPart {
  std::string folder;              ///< Below the output folder.
  std::vector<std::string> words;  ///< Command of the program, without --out.
  std::string needs;               ///< Folder of a part that must be made before; empty: none.
  std::string files;               ///< State of the files that it is made of, see FileStates.
};

/// How the poses of a run are judged.
struct BenchmarkJudgment {
  std::string ground_truth;  ///< Recording, trajectory or relations; empty: none, poses are not judged.
  std::string alignment;     ///< "se3", "sim3", "yaw"; empty: yaw in a plane, else as the run claims.
  double false_pose_limit_m = 0.1;
  bool measures_map = true;      ///< The world of its map is the first camera of the recording.
  bool localized = false;        ///< In the map of `map_folder`: judged in its frame.
  bool same_world = true;        ///< False: every localized pose is false.
  std::string map_ground_truth;  ///< Of the run that made the map.
};

/// One run of the list, with what it needs.
struct BenchmarkRun {
  std::string entry;               ///< Name of its entry.
  std::string id;                  ///< Its name as a file.
  std::uint64_t seed = 0;          ///< Of the world; 0 for a recording.
  std::vector<std::string> words;  ///< Command of the program, without --out.
  std::string recording, map;      ///< Folders of the parts that it needs; empty: none.
  std::string files;               ///< State of what it, its parts and its judge read, see FileStates.
  bool may_refuse = false;         ///< The input is wrong or the place is not in the map: refusing it is an answer.
  BenchmarkJudgment judgment;
};

struct BenchmarkPlan {
  std::vector<BenchmarkRun> runs;  ///< Those of one recording follow each other.
  std::map<std::string, BenchmarkPart> parts;

  /// Everything that decides the result of a run but the program itself and the files that it reads: its commands and
  /// how it is judged.
  std::string command_of(const BenchmarkRun& run) const;
};

/// Every run of the list. `data_folder`: what relative paths of recordings are relative to. Error for a recording that
/// does not exist.
BenchmarkPlan plan_benchmark(const BenchmarkList& list, const std::filesystem::path& data_folder);

/// Letters, digits, '.', '_' and '-' of a text, others as '_', and a few digits of its hash where that changed it.
std::string as_file_name(const std::string& text);

}  // namespace rastro::cli
