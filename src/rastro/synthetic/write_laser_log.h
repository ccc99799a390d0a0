// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "rastro/base/task_pool.h"
#include "rastro/synthetic/laser_world.h"
#include "rastro/synthetic/odometry_model.h"

namespace rastro {

struct LaserLogOptions {
  std::optional<std::int64_t> scans;  ///< Number of scans from the start; without it, the whole drive.
  OdometryModel odometry = {};
  bool force = false;  ///< Write to a folder that is not empty.
};

struct LaserLogSummary {
  std::int64_t scans = 0;
  std::int64_t relations = 0;
  double path_m = 0.0;          ///< True path length.
  double odometry_off_m = 0.0;  ///< Largest position error of the wheel odometry.
  std::uintmax_t bytes = 0;     ///< Of the log.
};

/// Writes the recording of a robot with a 2D laser: scans.log (CARMEN, ROBOTLASER1 lines with the odometry),
/// groundtruth.txt (TUM, the body), relations.txt, floor_plan.pgm and .yaml, landmarks.txt and landmarks_truth.csv;
/// README.txt there describes them. The same bytes for any pool. `progress` is called with the number of scans written
/// so far. Throws Error for folders that cannot be written or are not empty, and for a number of scans below 1.
LaserLogSummary write_laser_log(const LaserWorld& world, const std::filesystem::path& folder,
                                const LaserLogOptions& options, TaskPool& pool,
                                const std::function<void(std::int64_t)>& progress = {});

/// Two scans with the true relative pose from the first to the second.
struct ScanPair {
  std::int64_t first = 0, second = 0;
};
/// For every meter of the path, and for every half meter driven before, relative to the nearest scan of then.
std::vector<ScanPair> relation_pairs(const LaserWorld& world, std::int64_t scans);

/// The landmarks observed at one moment, within 6 m and visible to the laser: noise of 2 % on ranges and 1 degree on
/// bearings (normal). Range and bearing are relative to the body.
std::vector<LandmarkMeasurement> sight_landmarks(const LaserWorld& world, std::int64_t scan);

}  // namespace rastro
