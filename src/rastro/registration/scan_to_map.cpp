// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/scan_to_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

constexpr float nothing_known = 128.0F / 255.0F;

/// Value and derivatives of the map at one position, by meters.
struct MapValue {
  float value = nothing_known, by_x = 0.0F, by_y = 0.0F;
};

/// Bilinear between the centers of cells (Kohlbrecher et al. 2011, equations 4 to 6).
class Sampler {
 public:
  explicit Sampler(const ProbabilityView& map) : map_(map), per_meter_(static_cast<float>(1.0 / map.cell_m)) {}

  const Eigen::Vector2d& origin() const { return map_.origin; }

  /// Position relative to the grid's corner.
  MapValue at(float x, float y) const {
    const float u = x * per_meter_ - 0.5F, v = y * per_meter_ - 0.5F;
    const float column = std::floor(u), row = std::floor(v);
    if (!holds(column, row)) return {};
    const float fx = u - column, fy = v - row;
    const std::uint8_t* cell = cell_at(column, row);
    constexpr float unit = 1.0F / 255.0F;
    const float p00 = unit * static_cast<float>(cell[0]), p10 = unit * static_cast<float>(cell[1]);
    const float p01 = unit * static_cast<float>(cell[map_.width]),
                p11 = unit * static_cast<float>(cell[map_.width + 1]);
    const float lower = p00 + fx * (p10 - p00), upper = p01 + fx * (p11 - p01);
    return {lower + fy * (upper - lower), per_meter_ * ((1.0F - fy) * (p10 - p00) + fy * (p11 - p01)),
            per_meter_ * (upper - lower)};
  }

  /// Whether one of the four cells around the position is rather occupied.
  bool is_beside_occupied(float x, float y) const {
    const float column = std::floor(x * per_meter_ - 0.5F), row = std::floor(y * per_meter_ - 0.5F);
    if (!holds(column, row)) return false;
    const std::uint8_t* cell = cell_at(column, row);
    return std::max({cell[0], cell[1], cell[map_.width], cell[map_.width + 1]}) > LogOddsSteps::nothing_known;
  }

  /// Whether anything is known of the four cells around the position.
  bool knows(float x, float y) const {
    const float column = std::floor(x * per_meter_ - 0.5F), row = std::floor(y * per_meter_ - 0.5F);
    if (!holds(column, row)) return false;
    const std::uint8_t* cell = cell_at(column, row);
    constexpr std::uint8_t unknown = LogOddsSteps::nothing_known;
    return cell[0] != unknown || cell[1] != unknown || cell[map_.width] != unknown || cell[map_.width + 1] != unknown;
  }

 private:
  bool holds(float column, float row) const {
    return column >= 0.0F && row >= 0.0F && column < static_cast<float>(map_.width - 1) &&
           row < static_cast<float>(map_.height - 1);
  }
  const std::uint8_t* cell_at(float column, float row) const {
    return map_.cells + static_cast<std::ptrdiff_t>(row) * map_.width + static_cast<std::ptrdiff_t>(column);
  }

  const ProbabilityView& map_;
  float per_meter_;
};

struct NormalEquations {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double sum = 0.0, squares = 0.0;  ///< Sums of 1 - M.
};

NormalEquations accumulate(const Sampler& map, std::span<const Eigen::Vector2d> points, const Eigen::Vector3d& pose) {
  const auto c = static_cast<float>(std::cos(pose.z())), s = static_cast<float>(std::sin(pose.z()));
  const auto tx = static_cast<float>(pose.x() - map.origin().x()), ty = static_cast<float>(pose.y() - map.origin().y());
  float xx = 0, xy = 0, xa = 0, yy = 0, ya = 0, aa = 0, rx = 0, ry = 0, ra = 0, sum = 0, squares = 0;
  for (const Eigen::Vector2d& point : points) {
    const auto px = static_cast<float>(point.x()), py = static_cast<float>(point.y());
    const float dx = c * px - s * py, dy = s * px + c * py;
    const MapValue m = map.at(dx + tx, dy + ty);
    const float error = 1.0F - m.value, by_angle = m.by_y * dx - m.by_x * dy;
    xx += m.by_x * m.by_x;
    xy += m.by_x * m.by_y;
    xa += m.by_x * by_angle;
    yy += m.by_y * m.by_y;
    ya += m.by_y * by_angle;
    aa += by_angle * by_angle;
    rx += m.by_x * error;
    ry += m.by_y * error;
    ra += by_angle * error;
    sum += error;
    squares += error * error;
  }
  NormalEquations normal;
  normal.information << xx, xy, xa, xy, yy, ya, xa, ya, aa;
  normal.gradient << rx, ry, ra;
  normal.sum = sum;
  normal.squares = squares;
  return normal;
}

void judge_mapped_part(const Sampler& map, std::span<const Eigen::Vector2d> points, const SE2& map_from_body,
                       ScanToMapFit& fit) {
  float sum = 0.0F;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2f end = (map_from_body * point - map.origin()).cast<float>();
    if (!map.knows(end.x(), end.y())) continue;
    ++fit.mapped;
    sum += map.at(end.x(), end.y()).value;
  }
  if (fit.mapped > 0) fit.agreement = static_cast<double>(sum) / fit.mapped;
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// The longest single step: beyond a cell the map's gradient is meaningless.
Eigen::Vector3d limited(Eigen::Vector3d step, double cell_m) {
  const double longest = 2.0 * cell_m;
  constexpr double largest_turn = 0.2;
  const double length = step.head<2>().norm();
  if (length > longest) step.head<2>() *= longest / length;
  step.z() = std::clamp(step.z(), -largest_turn, largest_turn);
  return step;
}

Eigen::Vector3d vector_of(const SE2& pose) {
  return {pose.translation().x(), pose.translation().y(), pose.rotation().angle()};
}

}  // namespace

std::optional<ScanToMapFit> match_scan_to_map(std::span<const ProbabilityView> levels,
                                              std::span<const Eigen::Vector2d> points, const SE2& guess,
                                              const ScanPrior* prior, const ScanToMapOptions& options) {
  if (points.empty() || levels.empty()) return std::nullopt;
  Eigen::Vector3d pose = vector_of(guess);
  const Eigen::Vector3d expected = prior ? vector_of(prior->pose) : pose;
  for (std::size_t level = levels.size(); level-- > 0;) {
    const Sampler map(levels[level]);
    for (int i = 0; i < options.iterations; ++i) {
      const NormalEquations normal = accumulate(map, points, pose);
      Eigen::Matrix3d information = normal.information;
      Eigen::Vector3d gradient = normal.gradient;
      if (prior) {
        Eigen::Vector3d off = expected - pose;
        off.z() = wrapped(off.z());
        information += prior->information;
        gradient += prior->information * off;
      }
      // A direction without information from map or prior keeps its value.
      information.diagonal().array() += 1e-6 * information.trace() + 1e-9;
      const Eigen::Vector3d step = limited(information.ldlt().solve(gradient), levels[level].cell_m);
      if (!step.allFinite()) break;
      pose += step;
      if (step.norm() < options.smallest_step_m) break;
    }
  }
  const Sampler finest(levels.front());
  const NormalEquations last = accumulate(finest, points, pose);
  const auto count = static_cast<double>(points.size());
  ScanToMapFit fit;
  fit.map_from_body = SE2(SO2::from_angle(pose.z()), pose.head<2>());
  fit.information = last.information;
  fit.score = 1.0 - last.sum / count;
  fit.residual_variance = last.squares / count;
  judge_mapped_part(finest, points, fit.map_from_body, fit);
  return fit;
}

std::vector<Eigen::Vector2d> agreeing_points(const ProbabilityView& map, std::span<const Eigen::Vector2d> points,
                                             const SE2& map_from_body) {
  const Sampler sampler(map);
  std::vector<Eigen::Vector2d> agreeing;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2f end = (map_from_body * point - sampler.origin()).cast<float>();
    if (sampler.is_beside_occupied(end.x(), end.y())) agreeing.push_back(point);
  }
  return agreeing;
}

double score_of(const ProbabilityView& map, std::span<const Eigen::Vector2d> points, const SE2& map_from_body) {
  if (points.empty()) return 0.0;
  const NormalEquations normal = accumulate(Sampler(map), points, vector_of(map_from_body));
  return 1.0 - normal.sum / static_cast<double>(points.size());
}

}  // namespace rastro
