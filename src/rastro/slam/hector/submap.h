// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/map/grid/log_odds_grid.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/registration/correlative_search.h"
#include "rastro/sensor/laser_scan.h"
#include "rastro/slam/hector/options.h"

namespace rastro {

/// The returns of one scan in the body frame, and the laser's position in it.
using ScanPoints = KeyframeScan;

/// The returns within the range limits of the options.
ScanPoints returns_of(const LaserScan& scan, const HectorOptions& options);

/// A scan inserted into the map.
struct KeyScan {
  std::int64_t frame = 0;  ///< Index in the recording.
  TimeNs stamp = 0;
  ScanPoints scan;
  SE2 local_from_body;                                             ///< As the matcher estimated it.
  double path_m = 0.0;                                             ///< Path length up to here.
  std::optional<Eigen::Vector2d> unseen_direction = std::nullopt;  ///< Body frame; unobservable in the scan.
  bool assumed_motion = false;                                     ///< No odometry told the way to it.
  /// Of the step to it after missing scans, (x, y, angle), local axes; otherwise zero.
  Eigen::Matrix3d gap_covariance = Eigen::Matrix3d::Zero();
};

/// A part of the map, made of consecutive key scans, with cells of several sizes. Its frame has its origin at the first
/// scan and the axes of the matcher's local frame.
class Submap {
 public:
  Submap(const HectorOptions& options, const SE2& local_from_body);

  const SE2& local_from_submap() const { return local_from_submap_; }
  void insert(const ScanPoints& scan, const SE2& local_from_body, std::size_t key_scan);
  /// Finest first; valid until the next insert().
  const std::vector<ProbabilityView>& levels() const { return views_; }
  const std::vector<std::size_t>& key_scans() const { return key_scans_; }
  /// No more scans are inserted: frees the memory that only insert() needs.
  void finish();
  bool finished() const { return finished_; }
  /// For the search over a large window; computed on first use, and again after insert().
  const CorrelativeMap& correlative();
  /// Frees its memory, which is several times that of the cells.
  void forget_correlative() { correlative_.reset(); }
  /// Frees the cells of a finished submap: no scan can be matched to it any more.
  void release();
  bool released() const { return grids_.empty(); }
  /// Memory of the cells and of the search data.
  std::size_t bytes() const;

 private:
  SE2 local_from_submap_;
  std::vector<LogOddsGrid> grids_;
  std::vector<ProbabilityView> views_;
  std::vector<std::size_t> key_scans_;
  std::unique_ptr<CorrelativeMap> correlative_;
  bool finished_ = false;
};

}  // namespace rastro
