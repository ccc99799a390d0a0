// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/odometry_scale.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr double stretch_m = 0.3;
constexpr std::size_t fewest_stretches = 6, most_stretches = 30;
constexpr double spread = 0.15, least_alike = 0.8;
/// Slip, tire pressure and the cells of the map explain less than this.
constexpr double clearly_other = 1.25;
/// Once another one is found, smaller changes are noise.
constexpr double refined = 0.02;
/// Beyond this it is a matter of units, in which the laser's place on the robot is wrong as well.
constexpr double other_unit = 4.0;

}  // namespace

void OdometryScale::add(const Eigen::Vector2d& by_odometry, const Eigen::Vector2d& by_scans) {
  path_m_ += by_scans.norm();
  along_ += by_odometry.dot(by_scans);
  squared_ += by_odometry.squaredNorm();
  if (path_m_ < stretch_m) return;
  if (squared_ > 0.0) ratios_.push_back(along_ / squared_);
  if (ratios_.size() > most_stretches) ratios_.pop_front();
  path_m_ = along_ = squared_ = 0.0;
  judge();
}

void OdometryScale::judge() {
  if (ratios_.size() < fewest_stretches) return;
  const double usual = upper_median(std::vector<double>(ratios_.begin(), ratios_.end()));
  const auto alike = std::count_if(ratios_.begin(), ratios_.end(),
                                   [&](double ratio) { return std::abs(ratio - usual) < spread * std::abs(usual); });
  if (static_cast<double>(alike) < least_alike * static_cast<double>(ratios_.size())) return;
  if (std::abs(usual) < 1.0 / other_unit || std::abs(usual) > other_unit) return;
  const bool right = usual > 1.0 / clearly_other && usual < clearly_other;
  const bool found = factor_ != 1.0;
  if (found ? std::abs(usual / factor_ - 1.0) > refined : !right) factor_ = usual;
}

}  // namespace rastro
