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
/// Stretches that tell how wrong odometry is.
constexpr std::size_t fewest_for_error = 20, most_for_error = 200;
/// Floors differ, and wheels are worn: what was learned elsewhere is not better than this.
constexpr double least_share = 0.005;
/// Beyond this it is a matter of units, in which the laser's place on the robot is wrong as well.
constexpr double other_unit = 4.0;

}  // namespace

void OdometryScale::add(const Eigen::Vector2d& by_odometry, const Eigen::Vector2d& by_scans) {
  path_m_ += by_scans.norm();
  // Lengths, not their squares: the noise of each step would make odometry seem too long.
  by_odometry_m_ += by_odometry.norm();
  along_m_ += by_scans.dot(by_odometry.stableNormalized());
  if (path_m_ < stretch_m) return;
  if (by_odometry_m_ > 0.0) {
    ratios_.push_back(along_m_ / by_odometry_m_);
    for_error_.push_back(ratios_.back());
  }
  if (ratios_.size() > most_stretches) ratios_.pop_front();
  if (for_error_.size() > most_for_error) for_error_.pop_front();
  path_m_ = by_odometry_m_ = along_m_ = 0.0;
  judge();
}

OdometryError OdometryScale::error(double unknown_share) const {
  if (for_error_.size() < fewest_for_error) return {unknown_share, 0.0};
  std::vector<double> ratios(for_error_.begin(), for_error_.end());
  const double usual = upper_median(ratios);
  for (double& ratio : ratios) ratio = std::abs(ratio - usual);
  constexpr double sigma_of_median_deviation = 1.4826;  // of a normal distribution
  const double sigma = sigma_of_median_deviation * upper_median(ratios) / std::abs(factor_);
  const double of_usual = sigma / std::sqrt(static_cast<double>(ratios.size()));
  const double share = std::hypot(usual / factor_ - 1.0, of_usual, least_share);
  return {share, sigma * sigma * stretch_m};
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
