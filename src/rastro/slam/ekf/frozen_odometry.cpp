// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/frozen_odometry.h"

#include <algorithm>
#include <cmath>

#include "rastro/math/same_pose.h"

namespace rastro {
namespace {

constexpr int fewest_unmoved = 3, fewest_landmarks = 2;
/// A sum of squared Mahalanobis distances above its mean by this many of its standard deviations is no chance.
constexpr double clear_sigmas = 6.0;
/// People who walk by change fewer beams.
constexpr double moved_share = 0.4, still_share = 0.15;

}  // namespace

void FrozenOdometry::add(const Frame& frame) {
  const auto& odometry = frame.odometry_from_body;
  const bool unmoved = odometry && last_ && same_pose(*last_, *odometry);
  thaw_.reset();
  now_ = frame.stamp;
  if (unmoved) {
    add_unmoved(frame);
  } else {
    add_moved(frame);
  }
  last_ = odometry;
}

void FrozenOdometry::add_unmoved(const Frame& frame) {
  // Odometry that changed and is the same again may be slower than the frames.
  if (unmoved_ == 0) frozen_ = false;
  ++unmoved_;
  if (frozen_ || !frame.scan) return;
  if (!scan_) {
    scan_ = *frame.scan;
  } else if (unmoved_ >= fewest_unmoved) {
    const double changed = changed_share(*frame.scan, 0.15, 0.03).value_or(0.0);
    frozen_ = changed > moved_share;
    scan_still_ = changed < still_share;
    if (changed_share(*frame.scan, 0.04, 0.01).value_or(1.0) < still_share) stood_ = now_;
  }
}

void FrozenOdometry::add_moved(const Frame& frame) {
  // Before it was seen to move, it may have stood for long.
  const TimeNs moved = frozen_ ? std::max(since_, stood_) : since_;
  const double blind = to_seconds(now_ - std::max(moved, recognized_));
  if (unmoved_ >= fewest_unmoved && blind_ >= std::min(unmoved_, most_blind))
    thaw_ = Thaw{to_seconds(now_ - since_), blind / to_seconds(now_ - moved), frozen_};
  // Its first step is no motion since the last frame unless nothing else told how the body moved.
  frozen_ = frozen_ && !thaw_ && unmoved_ > 0;
  unmoved_ = 0;
  since_ = stood_ = frame.stamp;
  if (!frozen_) told_ = now_;
  scan_.reset();
  scan_still_ = false;
}

std::optional<double> FrozenOdometry::changed_share(const LaserScan& scan, double clear_m,
                                                    double clear_range_share) const {
  if (scan.ranges.size() != scan_->ranges.size()) return std::nullopt;
  int seen = 0, changed = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.is_return(beam) || !scan_->is_return(beam)) continue;
    ++seen;
    const double before = scan_->ranges[beam];
    changed += std::abs(scan.ranges[beam] - before) > clear_m + clear_range_share * before ? 1 : 0;
  }
  return seen > 0 ? std::optional<double>(static_cast<double>(changed) / seen) : std::nullopt;
}

void FrozenOdometry::judge(std::span<const LandmarkAssociation> associations) {
  using Kind = LandmarkAssociation::Kind;
  int known = 0;
  double sum = 0.0;
  for (const auto& [kind, landmark, distance] : associations) {
    if (kind != Kind::landmark && kind != Kind::contradicting) continue;
    ++known;
    sum += distance;
  }
  const double degrees_of_freedom = 2.0 * known;
  const bool moved =
      known >= fewest_landmarks && sum > degrees_of_freedom + clear_sigmas * std::sqrt(2.0 * degrees_of_freedom);
  // Landmarks that were off before tell of a wrong map.
  if (unmoved_ < fewest_unmoved) fitted_ = known >= fewest_landmarks && !moved;
  if (!frozen_ && unmoved_ >= fewest_unmoved) frozen_ = moved && fitted_ && !scan_still_;
}

void FrozenOdometry::end_frame(std::span<const LandmarkAssociation> associations) {
  const bool recognized = std::any_of(associations.begin(), associations.end(), [](const LandmarkAssociation& one) {
    return one.kind == LandmarkAssociation::Kind::landmark;
  });
  blind_ = recognized ? 0 : blind_ + 1;
  if (recognized) recognized_ = told_ = now_;
}

}  // namespace rastro
