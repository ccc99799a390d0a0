// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/landmark_check.h"

#include <fmt/format.h>

#include <cmath>

#include "rastro/input_check/share_near.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

// Over a motion in this range the errors of ranges and headings are small beside it.
constexpr double compared_m = 0.5, longest_m = 2.0, largest_rad = 0.6;
constexpr std::size_t least_ratios = 12, most_ratios = 400;
constexpr double most_ratio = 1.35, least_agreeing = 0.6, most_right = 0.15;

}  // namespace

void LandmarkCheck::add(const Frame& frame, InputWarnings& found) {
  if (told_ || !frame.odometry_from_body || ratios_.size() >= most_ratios) return;
  for (const LandmarkMeasurement& seen : frame.landmarks) {
    if (seen.id < 0 || !std::isfinite(seen.range) || !std::isfinite(seen.bearing)) continue;
    compare(seen.id,
            {*frame.odometry_from_body, seen.range * Eigen::Vector2d(std::cos(seen.bearing), std::sin(seen.bearing))});
  }
  judge(found);
}

void LandmarkCheck::compare(std::int64_t id, const Observation& now) {
  const auto [found, fresh] = first_.try_emplace(id, now);
  if (fresh) return;
  const SE2 motion = found->second.odometry_from_body.inverse() * now.odometry_from_body;
  const double meters = motion.translation().norm();
  if (meters < compared_m && std::abs(motion.rotation().angle()) < largest_rad) return;
  if (meters >= compared_m && meters <= longest_m && std::abs(motion.rotation().angle()) <= largest_rad) {
    const Eigen::Vector2d by_landmark = found->second.in_body - motion.rotation() * now.in_body;
    ratios_.push_back(by_landmark.dot(motion.translation()) / (meters * meters));
  }
  found->second = now;
}

void LandmarkCheck::judge(InputWarnings& found) {
  if (ratios_.size() < least_ratios) return;
  const double ratio = upper_median(ratios_);
  if (ratio < most_ratio && ratio > 1.0 / most_ratio) return;
  if (share_near(ratios_, ratio) < least_agreeing || share_near(ratios_, 1.0) > most_right) return;
  told_ = true;
  found.push_back(
      {"landmark_scale", fmt::format("{} motions against landmarks are {:.2f} times as long as by odometry: "
                                     "check the unit of the ranges, or scale and sign of the odometry",
                                     ratios_.size(), ratio)});
}

}  // namespace rastro
