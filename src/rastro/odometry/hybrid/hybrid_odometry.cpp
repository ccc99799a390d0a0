// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/hybrid_odometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/checked_options.h"
#include "rastro/base/random.h"
#include "rastro/base/stopwatch.h"
#include "rastro/math/median.h"
#include "rastro/multiview/triangulation.h"

namespace rastro {
namespace {

TrackOptions track_options(const HybridOptions& options) {
  TrackOptions track;
  // Points are needed over three frames; re-identified ones would not help.
  track.mode = "klt";
  track.features = options.features;
  track.min_distance_px = options.min_distance_px;
  track.seed = options.seed;
  return track;
}

}  // namespace

HybridOdometry::HybridOdometry(const HybridOptions& options, const Camera& camera, TaskPool* pool)
    : options_(checked(options, "odometry options")),
      camera_(camera),
      check_(options.check),
      rotations_(options.rotation, camera),
      tracker_(track_options(options), camera, pool) {}

OdometryUpdate HybridOdometry::process(const Frame& frame) {
  Stopwatch watch;
  OdometryUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  const FrameCheckResult check = check_.check(frame.image, frame.stamp);
  update.reason = check.reason;
  update.detail = check.detail;
  trajectory_.push_back({frame.stamp, world_from_last_});
  seen_.clear();
  if (check.useful()) {
    follow(frame, update);
  } else {
    bridge(update);
  }
  trajectory_.back().world_from_body = update.world_from_camera = world_from_last_;
  update.milliseconds = watch.lap_ms();
  return update;
}

void HybridOdometry::follow(const Frame& frame, OdometryUpdate& update) {
  View current;
  current.position = trajectory_.size() - 1;
  current.features = tracker_.process(frame.image, frame.stamp).features;
  seen_ = current.features;
  const auto rotation = rotations_.step(frame.image, bridged_ + 1);
  if (!rotation) {
    first_ = std::move(current);
    used_ = {world_from_last_, first_->position};
    update.reason = OdometryReason::first_frame;
    return;
  }
  const SO3 world_from_current = world_from_rotated_ * rotation->reference_from_current;
  if (!rotation->measured.still) world_from_rotated_ = world_from_current;
  update.confidence = rotation->measured.columns.confidence;
  current.world_from_camera = predicted(world_from_current);
  if (second_) {
    locate(std::move(current), update);
  } else {
    start(std::move(current), update);
  }
  bridged_ = 0;
  used_ = {world_from_last_, trajectory_.size() - 1};
}

std::vector<OdometryFeature> HybridOdometry::features() const {
  std::vector<OdometryFeature> features;
  for (const TrackedFeature& seen : seen_) {
    const bool fresh = seen.state == TrackState::fresh;
    features.push_back({seen.pixel, seen.id, fresh ? OdometryFeature::State::fresh : OdometryFeature::State::matched});
  }
  return features;
}

SE3 HybridOdometry::predicted(const SO3& world_from_current) const {
  const Eigen::Vector3d motion = world_from_last_.rotation() * velocity_;
  return {world_from_current, world_from_last_.translation() + motion};
}

CalibratedRansacOptions HybridOdometry::ransac_options(std::uint64_t item) const {
  CalibratedRansacOptions ransac;
  ransac.max_error_px = options_.max_error_px;
  ransac.max_iterations = options_.ransac_iterations;
  ransac.seed = seed_for(options_.seed, item);
  ransac.focal_px = camera_.fx;
  return ransac;
}

HybridOdometry::Shared HybridOdometry::shared_between(const View& a, const View& b) const {
  Shared shared;
  const SO3 b_from_a = b.world_from_camera.rotation().inverse() * a.world_from_camera.rotation();
  std::vector<double> motions, parallaxes;
  auto in_b = b.features.begin();
  for (const auto& feature : a.features) {
    while (in_b != b.features.end() && in_b->id < feature.id) ++in_b;
    if (in_b == b.features.end()) break;
    if (in_b->id != feature.id || !feature.ray.allFinite() || !in_b->ray.allFinite()) continue;
    shared.a.push_back(feature.ray.cast<double>());
    shared.b.push_back(in_b->ray.cast<double>());
    shared.ids.push_back(feature.id);
    motions.push_back(static_cast<double>((feature.pixel - in_b->pixel).norm()));
    const Eigen::Vector3d rotated = b_from_a * shared.a.back().homogeneous().eval();
    if (rotated.z() > 0.0) parallaxes.push_back((rotated.hnormalized() - shared.b.back()).norm() * camera_.fx);
  }
  shared.motion_px = upper_median_or(std::move(motions), 0.0);
  shared.parallax_px = upper_median_or(std::move(parallaxes), 0.0);
  return shared;
}

std::vector<HybridOdometry::KnownPoint> HybridOdometry::triangulate_between(const View& a, const View& b) const {
  const SE3 b_from_a = b.world_from_camera.inverse() * a.world_from_camera;
  const TriangulationOptions options{camera_.fx, options_.max_point_error_px, options_.min_point_parallax_deg};
  const Shared shared = shared_between(a, b);
  std::vector<KnownPoint> points;
  for (std::size_t i = 0; i < shared.ids.size(); ++i) {
    if (const auto point = triangulate(b_from_a, shared.a[i], shared.b[i], options)) {
      points.push_back({shared.ids[i], point->position});
    }
  }
  return points;
}

void HybridOdometry::start(View current, OdometryUpdate& update) {
  const Shared shared = shared_between(*first_, current);
  update.matches = static_cast<int>(shared.ids.size());
  update.state = speed_ > 0.0 ? OdometryState::lost : OdometryState::initializing;
  const auto wait = [&](OdometryReason reason, std::string detail) {
    if (update.reason == OdometryReason::none) {
      update.reason = reason;
      update.detail = std::move(detail);
    }
    world_from_last_ = current.world_from_camera;
  };
  if (update.matches < options_.min_points) {
    wait(OdometryReason::too_few_points, fmt::format("{} points, need {}", update.matches, options_.min_points));
    first_ = std::move(current);
    return;
  }
  if (shared.motion_px < options_.min_motion_px) {
    update.reason = OdometryReason::no_motion;
    world_from_last_ = first_->world_from_camera;
    velocity_.setZero();
    return;
  }
  if (shared.parallax_px < options_.min_start_parallax_px) {
    const bool only_rotated = shared.motion_px > 4.0 * shared.parallax_px;
    wait(only_rotated ? OdometryReason::pure_rotation : OdometryReason::too_little_parallax,
         fmt::format("median parallax {:.1f} px, need {:.1f}", shared.parallax_px, options_.min_start_parallax_px));
    return;
  }
  const SO3 current_from_first = current.world_from_camera.rotation().inverse() * first_->world_from_camera.rotation();
  const auto fit =
      estimate_direction(current_from_first.matrix(), shared.a, shared.b, ransac_options(current.position));
  if (!fit || fit->inliers < options_.min_inlier_share * update.matches) {
    wait(OdometryReason::few_inliers,
         fmt::format("{} of {} points are inliers", fit ? fit->inliers : 0, update.matches));
    first_ = std::move(current);
    return;
  }
  const auto frames = static_cast<double>(current.position - first_->position);
  const double length = speed_ > 0.0 ? speed_ * frames : 1.0;
  const SE3 first_from_current = SE3(current_from_first, length * fit->translation).inverse();
  current.world_from_camera = first_->world_from_camera * first_from_current;
  update.inliers = fit->inliers;
  update.state = OdometryState::tracking;
  speed_ = length / frames;
  velocity_ = first_from_current.translation() / frames;
  world_from_last_ = current.world_from_camera;
  second_ = std::move(current);
  interpolate_between(first_->position, second_->position);
  points_ = triangulate_between(*first_, *second_);
}

void HybridOdometry::locate(View current, OdometryUpdate& update) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> seen;
  auto feature = current.features.begin();
  for (const auto& point : points_) {
    while (feature != current.features.end() && feature->id < point.id) ++feature;
    if (feature == current.features.end()) break;
    if (feature->id != point.id || !feature->ray.allFinite()) continue;
    points.push_back(point.position);
    seen.push_back(feature->ray.cast<double>());
  }
  update.matches = static_cast<int>(points.size());
  const Shared since_second = shared_between(*second_, current);
  if (static_cast<int>(since_second.ids.size()) >= options_.min_points &&
      since_second.motion_px < options_.min_motion_px) {
    update.state = OdometryState::tracking;
    update.reason = OdometryReason::no_motion;
    update.inliers = update.matches;
    world_from_last_ = second_->world_from_camera;
    velocity_.setZero();
    return;
  }
  if (update.matches < options_.min_points) {
    lose(std::move(current), OdometryReason::too_few_points,
         fmt::format("{} points, need {}", update.matches, options_.min_points), update);
    return;
  }
  const SO3 current_from_first = current.world_from_camera.rotation().inverse() * first_->world_from_camera.rotation();
  const SE3 guess = current.world_from_camera.inverse() * first_->world_from_camera;
  const auto fit = estimate_translation(current_from_first.matrix(), points, seen, ransac_options(current.position),
                                        guess.translation());
  if (!fit || fit->inliers < options_.min_inlier_share * update.matches) {
    lose(std::move(current), OdometryReason::few_inliers,
         fmt::format("{} of {} points are inliers", fit ? fit->inliers : 0, update.matches), update);
    return;
  }
  current.world_from_camera = first_->world_from_camera * SE3(current_from_first, fit->translation).inverse();
  const double step = (current.world_from_camera.translation() - used_.world_from_camera.translation()).norm();
  if (step > options_.max_speed_ratio * speed_ * frames_since_used(current)) {
    lose(std::move(current), OdometryReason::few_inliers,
         fmt::format("motion of {:.1f} after a motion of {:.1f}", step, speed_), update);
    return;
  }
  update.inliers = fit->inliers;
  update.state = update.reason == OdometryReason::gap ? OdometryState::weak : OdometryState::tracking;
  accept(std::move(current), since_second);
}

void HybridOdometry::accept(View current, const Shared& since_second) {
  const Eigen::Vector3d moved = used_.world_from_camera.inverse() * current.world_from_camera.translation();
  velocity_ = moved / frames_since_used(current);
  // A motion of nearly zero is no reference for the speed.
  speed_ = std::max(velocity_.norm(), 0.5 * speed_);
  world_from_last_ = current.world_from_camera;
  if (since_second.parallax_px < options_.min_parallax_px) return;
  first_ = std::move(second_);
  second_ = std::move(current);
  points_ = triangulate_between(*first_, *second_);
}

void HybridOdometry::lose(View current, OdometryReason reason, std::string detail, OdometryUpdate& update) {
  update.state = OdometryState::lost;
  if (update.reason == OdometryReason::none) {
    update.reason = reason;
    update.detail = std::move(detail);
  }
  current.world_from_camera = predicted(current.world_from_camera.rotation());
  world_from_last_ = current.world_from_camera;
  first_ = std::move(current);
  second_.reset();
  points_.clear();
}

void HybridOdometry::bridge(OdometryUpdate& update) {
  update.used = false;
  update.confidence = 0.0;
  update.state = first_ ? OdometryState::weak : OdometryState::initializing;
  if (!first_ || update.reason == OdometryReason::repeated_frame) return;
  if (++bridged_ > options_.max_bridged_frames) {
    update.state = OdometryState::lost;
    return;
  }
  world_from_last_ = predicted(world_from_last_.rotation() * rotations_.last_rotation());
}

/// The frames between the two views of an initialization got poses before the camera's translation was known.
void HybridOdometry::interpolate_between(std::size_t first, std::size_t last) {
  const SE3 from = first_->world_from_camera, to = second_->world_from_camera;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double share = static_cast<double>(i - first) / static_cast<double>(last - first);
    SE3& pose = trajectory_[i].world_from_body;
    pose = SE3(pose.rotation(), (1.0 - share) * from.translation() + share * to.translation());
  }
}

}  // namespace rastro
