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
#include "rastro/session/live_input.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/slam_result.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Progress of the run, after each frame.
struct SlamProgress {
  std::int64_t done = 0;               ///< Frames processed or skipped.
  std::optional<std::int64_t> frames;  ///< Total number of frames, if known.
  std::int64_t loops_closed = 0;
  const SlamUpdate* last = nullptr;
  const Frame* frame = nullptr;  ///< That of `last`.
};

/// The parts of one run. They must outlive slam_run().
struct SlamRun {
  Source* source = nullptr;
  LiveInput* live = nullptr;  ///< `source` in a live run, else null.
  Slam* method = nullptr;
  RunFolder* folder = nullptr;              ///< May be null: no stats, no events, no poses.
  const std::atomic<bool>* stop = nullptr;  ///< Set from outside (Ctrl-C): the run ends after the current frame.
  std::optional<std::int64_t> frames_asked;
  std::function<void(const SlamProgress&)> progress;
  std::function<GrayView(const Frame&)> mask_of;  ///< The mask for each frame; empty: nothing is masked.
  /// The archive given to the method, which gets the final map; may be null.
  GrowingMapFile* map_file = nullptr;
  SE3 initial_pose;  ///< Of the body at the first frame, in the world: calibration errors grow from there.
  std::size_t max_memory_bytes = 0;  ///< The run ends with an Error before it takes more; 0: no limit.
};

/// Uncertainty of the position at one point of the trajectory.
struct PositionCovariance {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();    ///< World, meters.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m^2
};

struct SlamRunEnd {
  SlamResult result;  ///< Without the method's name and the hash.
  Trajectory trajectory;
  std::shared_ptr<const Map> map;  ///< Null if the method could not give one any more.
  /// As first estimated, every two meters of path; empty if the method has no covariance.
  std::vector<PositionCovariance> position_covariances;
  std::vector<PlaceBelief> places;  ///< Of the keyframes of this run, by a method that recognizes places.
  std::exception_ptr failure;
  std::string first_skip;  ///< Why the first skipped frame could not be read.
};

/// Runs the method over the source to the end. Writes each pose as first estimated (trajectory_online.txt), with its
/// covariance if there is one (covariance_online.txt), and each change of state or reason and each event of the method
/// as a line of events.jsonl. Frames that cannot be read are skipped, counted and reported. A run that is stopped or
/// fails still returns the method's results so far.
SlamRunEnd slam_run(const SlamRun& run);

}  // namespace rastro
