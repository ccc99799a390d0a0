// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/graph/map.h"
#include "rastro/sensor/source.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/slam_result.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Where the run stands, after each frame.
struct SlamProgress {
  std::int64_t done = 0;               ///< Frames processed or skipped.
  std::optional<std::int64_t> frames;  ///< Of how many, where that is known.
  std::int64_t loops_closed = 0;
  const SlamUpdate* last = nullptr;
};

/// Everything one run is made of. The parts must outlive slam_run().
struct SlamRun {
  Source* source = nullptr;
  Slam* method = nullptr;
  RunFolder* folder = nullptr;              ///< May be null: no stats, no events, no poses.
  const std::atomic<bool>* stop = nullptr;  ///< Set from outside (Ctrl-C): the run ends after the current frame.
  std::optional<std::int64_t> frames_asked;
  std::function<void(const SlamProgress&)> progress;
  std::function<GreyView(const Frame&)> mask_of;  ///< Put into each frame; empty: nothing is masked.
  /// The archive that the method was given, which gets the final map; may be null.
  GrowingMapFile* map_file = nullptr;
  std::size_t max_memory_bytes = 0;  ///< The run ends with an Error before it takes more; 0: no ceiling.
};

/// How well the place at one point of the way was known.
struct PlaceCovariance {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();       ///< World, metres.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m^2
};

struct SlamRunEnd {
  SlamResult result;  ///< Without the method's name and the hash.
  Trajectory trajectory;
  std::shared_ptr<const Map> map;  ///< Null where the method could not give one any more.
  /// As first known, every two metres of the way; empty where the method has no covariance.
  std::vector<PlaceCovariance> places;
  std::exception_ptr failure;
  std::string first_skip;  ///< Why the first skipped frame could not be read.
};

/// Runs the method over the source and lets it finish. Each pose is written as it is first given
/// (trajectory_online.txt), with its covariance where there is one (covariance_online.txt), each change of state or
/// reason and each event of the method as a line of events.jsonl. Frames that cannot be read are skipped, counted and
/// reported; a run that is stopped or fails still gives what the method has.
SlamRunEnd slam_run(const SlamRun& run);

}  // namespace rastro
