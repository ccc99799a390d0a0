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
  std::optional<std::int64_t> scans;  ///< The first so many; without it, the whole drive.
  OdometryModel odometry = {};
  bool force = false;  ///< Write into a folder that is not empty.
};

struct LaserLogSummary {
  std::int64_t scans = 0;
  std::int64_t relations = 0;
  double way_m = 0.0;           ///< Driven, truly.
  double odometry_off_m = 0.0;  ///< How far the wheels are off at worst.
  std::uintmax_t bytes = 0;     ///< Of the log.
};

/// Writes the recording of a robot with a 2D laser: scans.log (CARMEN, ROBOTLASER1 lines with the odometry),
/// groundtruth.txt (TUM, the body), relations.txt, floor_plan.pgm and .yaml, landmarks.txt and landmarks_truth.csv;
/// README.txt there says what is in them. The same bytes for any pool. `progress` is called with the number of scans
/// written so far. Errors for folders that cannot be written or are not empty, and for a number of scans below 1.
LaserLogSummary write_laser_log(const LaserWorld& world, const std::filesystem::path& folder,
                                const LaserLogOptions& options, TaskPool& pool,
                                const std::function<void(std::int64_t)>& progress = {});

/// Two scans whose true motion from the first to the second is to be compared.
struct ScanPair {
  std::int64_t first = 0, second = 0;
};
/// For every metre of the way, and for every half metre that was driven before the nearest scan from then.
std::vector<ScanPair> relation_pairs(const LaserWorld& world, std::int64_t scans);

/// The landmarks seen at one moment, within 6 m and in sight of the laser: their ranges are off by 2 % and their
/// bearings by 1 degree (normal). Range and bearing are taken from the body.
std::vector<LandmarkSighting> sight_landmarks(const LaserWorld& world, std::int64_t scan);

}  // namespace rastro
