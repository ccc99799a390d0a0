// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/scan_motion.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "rastro/registration/correlative_search.h"
#include "rastro/registration/scan_to_map.h"

namespace rastro {
namespace {

constexpr double scan_cell_m = 0.1;
constexpr double farthest_return_m = 20.0;
constexpr double widest_surface_gap_m = 0.5;  // Between neighboring returns of one surface.
constexpr std::size_t least_returns = 30, most_points = 180;
constexpr int scan_search_levels = 5;
constexpr double least_fit = 0.6;
constexpr std::uint8_t at_surface = 255, beside_surface = 190;

/// Returns in the body frame, in the order of the beams.
std::vector<Eigen::Vector2d> body_points(const LaserScan& scan) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const auto range = static_cast<double>(scan.ranges[beam]);
    if (!scan.is_return(beam) || range > farthest_return_m) continue;
    const double angle = scan.angle_of(beam);
    const Eigen::Vector2d point =
        scan.body_from_laser * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle));
    if (point.allFinite()) points.push_back(point);
  }
  return points;
}

std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& points) {
  const std::size_t step = (points.size() + most_points - 1) / most_points;
  std::vector<Eigen::Vector2d> some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

}  // namespace

ScanMotion::ScanMotion(const LaserScan& scan) : points_(body_points(scan)) {
  if (points_.size() < least_returns) return;
  Eigen::Vector2d least = points_.front(), most = least;
  for (const Eigen::Vector2d& point : points_) {
    least = least.cwiseMin(point);
    most = most.cwiseMax(point);
  }
  constexpr int margin = 3;
  origin_ = least - Eigen::Vector2d::Constant(margin * scan_cell_m);
  width_ = static_cast<int>((most.x() - least.x()) / scan_cell_m) + 2 * margin + 1;
  height_ = static_cast<int>((most.y() - least.y()) / scan_cell_m) + 2 * margin + 1;
  cells_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    draw(points_[i]);
    if (i == 0) continue;
    const Eigen::Vector2d gap = points_[i] - points_[i - 1];
    const double length = gap.norm();
    if (length > widest_surface_gap_m) continue;
    for (double along = 0.5 * scan_cell_m; along < length; along += 0.5 * scan_cell_m)
      draw(points_[i - 1] + along / length * gap);
  }
}

ProbabilityView ScanMotion::view() const { return {cells_.data(), width_, height_, scan_cell_m, origin_}; }

void ScanMotion::draw(const Eigen::Vector2d& point) {
  const Eigen::Vector2i cell = ((point - origin_) / scan_cell_m).array().floor().cast<int>();
  for (int y = cell.y() - 1; y <= cell.y() + 1; ++y) {
    for (int x = cell.x() - 1; x <= cell.x() + 1; ++x) {
      std::uint8_t& value =
          cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
      value = std::max(value, x == cell.x() && y == cell.y() ? at_surface : beside_surface);
    }
  }
}

std::optional<ScanMotionFit> ScanMotion::match(const LaserScan& scan, double reach_m, double reach_rad) const {
  const std::vector<Eigen::Vector2d> all = body_points(scan);
  if (cells_.empty() || all.size() < least_returns) return std::nullopt;
  const std::vector<Eigen::Vector2d> points = thinned(all);
  const CorrelativeMap map(view(), scan_search_levels);
  const auto coarse = map.search(points, SE2(), {reach_m, reach_rad, least_fit});
  if (!coarse) return std::nullopt;
  const ProbabilityView level = view();
  const auto fine = match_scan_to_map({&level, 1}, points, coarse->map_from_body, nullptr, {});
  if (!fine) return std::nullopt;
  ScanMotionFit fit{fine->map_from_body, coarse->score, fine->information.topLeftCorner<2, 2>()};
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(fit.observed).eigenvalues().maxCoeff();
  if (!(largest > 0.0)) return std::nullopt;
  fit.observed /= largest;
  return fit;
}

}  // namespace rastro
