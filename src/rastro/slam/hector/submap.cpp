// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/submap.h"

#include <cmath>

namespace rastro {
namespace {

/// Squares of up to 64 cells (3.2 m at 5 cm): larger ones cover whole rooms and give no useful bound.
constexpr int search_levels = 7;

}  // namespace

ScanPoints returns_of(const LaserScan& scan, const HectorOptions& options) {
  ScanPoints out;
  out.sensor = scan.body_from_laser.translation();
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (!scan.is_return(i) || range < options.min_range_m || range > options.max_range_m) continue;
    const double angle = scan.angle_of(i);
    const Eigen::Vector2d point =
        scan.body_from_laser * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle));
    if (point.allFinite()) out.points.push_back(point);
  }
  return out;
}

Submap::Submap(const HectorOptions& options, const SE2& local_from_body)
    : local_from_submap_(SO2(), local_from_body.translation()) {
  const LogOddsModel model{options.occupied_probability, options.free_probability};
  for (int level = 0; level < options.levels; ++level) grids_.emplace_back(options.cell_m * (1 << level), model);
}

void Submap::insert(const ScanPoints& scan, const SE2& local_from_body, std::size_t key_scan) {
  const SE2 submap_from_body = local_from_submap_.inverse() * local_from_body;
  std::vector<Eigen::Vector2d> in_submap;
  in_submap.reserve(scan.points.size());
  for (const Eigen::Vector2d& point : scan.points) in_submap.push_back(submap_from_body * point);
  views_.clear();
  for (LogOddsGrid& grid : grids_) {
    grid.insert(submap_from_body * scan.sensor, in_submap);
    views_.push_back(grid.view());
  }
  key_scans_.push_back(key_scan);
  correlative_.reset();
}

void Submap::finish() {
  finished_ = true;
  views_.clear();
  for (LogOddsGrid& grid : grids_) {
    grid.freeze();
    views_.push_back(grid.view());
  }
}

void Submap::release() {
  grids_.clear();
  views_.clear();
  correlative_.reset();
}

std::size_t Submap::bytes() const {
  std::size_t bytes = sizeof(Submap) + key_scans_.size() * sizeof(std::size_t);
  for (const LogOddsGrid& grid : grids_) bytes += grid.bytes();
  if (correlative_)
    bytes += static_cast<std::size_t>(search_levels) * static_cast<std::size_t>(views_.front().width) *
             static_cast<std::size_t>(views_.front().height);
  return bytes;
}

const CorrelativeMap& Submap::correlative() {
  if (!correlative_) correlative_ = std::make_unique<CorrelativeMap>(views_.front(), search_levels);
  return *correlative_;
}

}  // namespace rastro
