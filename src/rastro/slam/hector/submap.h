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

/// The returns of one scan in the body frame, and where the laser stood in it.
using ScanPoints = KeyframeScan;

/// Those within the options' ranges.
ScanPoints returns_of(const LaserScan& scan, const HectorOptions& options);

/// A scan that went into the map.
struct KeyScan {
  std::int64_t frame = 0;  ///< Index in the recording.
  TimeNs stamp = 0;
  ScanPoints scan;
  SE2 local_from_body;                                             ///< As the matcher found it.
  double path_m = 0.0;                                             ///< Way up to here.
  std::optional<Eigen::Vector2d> unseen_direction = std::nullopt;  ///< Body frame; along it the scan tells nothing.
};

/// A piece of the map, made of consecutive key scans, in cells of several sizes. Its frame: the axes of the matcher's
/// local frame, at the first scan.
class Submap {
 public:
  Submap(const HectorOptions& options, const SE2& local_from_body);

  const SE2& local_from_submap() const { return local_from_submap_; }
  void insert(const ScanPoints& scan, const SE2& local_from_body, std::size_t key_scan);
  /// Finest first; valid until the next insert().
  const std::vector<ProbabilityView>& levels() const { return views_; }
  const std::vector<std::size_t>& key_scans() const { return key_scans_; }
  /// No scan goes in any more: memory that only insert() needs is given up.
  void finish();
  bool finished() const { return finished_; }
  /// For the search over a large window; made when first asked for, and again after insert().
  const CorrelativeMap& correlative();
  /// Gives up its memory, several times that of the cells.
  void forget_correlative() { correlative_.reset(); }

 private:
  SE2 local_from_submap_;
  std::vector<LogOddsGrid> grids_;
  std::vector<ProbabilityView> views_;
  std::vector<std::size_t> key_scans_;
  std::unique_ptr<CorrelativeMap> correlative_;
  bool finished_ = false;
};

}  // namespace rastro
