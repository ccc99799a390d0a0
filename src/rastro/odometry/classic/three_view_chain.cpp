// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/classic/three_view_chain.h"

#include <fmt/format.h>

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/multiview/absolute_pose.h"
#include "rastro/multiview/essential.h"
#include "rastro/multiview/triangulation.h"

namespace rastro {
namespace {

std::string inliers_text(int inliers, int matches) {
  return fmt::format("{} of {} points are inliers", inliers, matches);
}

}  // namespace

void ThreeViewChain::add(RayObservations observations, OdometryUpdate& update) {
  located_.clear();
  trajectory_.push_back({update.stamp, world_from_last_});
  View current{std::move(observations), trajectory_.size() - 1, world_from_last_};
  if (second_) {
    locate(std::move(current), update);
  } else {
    start(std::move(current), update);
  }
  trajectory_.back().world_from_body = update.world_from_camera = world_from_last_;
}

void ThreeViewChain::bridge(OdometryUpdate& update) {
  located_.clear();
  trajectory_.push_back({update.stamp, world_from_last_});
  update.used = false;
  update.confidence = 0.0;
  update.state = speed_ > 0.0 ? OdometryState::weak : OdometryState::initializing;
  if (update.reason != OdometryReason::repeated_frame) repeat_motion();
  if (repeated_ > options_.max_bridged_frames && speed_ > 0.0) update.state = OdometryState::lost;
  trajectory_.back().world_from_body = update.world_from_camera = world_from_last_;
}

CalibratedRansacOptions ThreeViewChain::ransac(double max_error_px, std::uint64_t item) const {
  CalibratedRansacOptions ransac;
  ransac.max_error_px = max_error_px;
  ransac.confidence = options_.ransac_confidence;
  ransac.max_iterations = options_.ransac_iterations;
  ransac.seed = seed_for(options_.seed, item);
  ransac.focal_px = focal_px_;
  return ransac;
}

void ThreeViewChain::start(View current, OdometryUpdate& update) {
  update.state = OdometryState::initializing;
  update.reason = OdometryReason::first_frame;
  second_ = std::move(current);
}

void ThreeViewChain::locate(View current, OdometryUpdate& update) {
  const SharedRays shared = shared_rays(second_->observations, current.observations);
  update.matches = static_cast<int>(shared.ids.size());
  if (update.matches < options_.min_points) {
    lose(std::move(current), OdometryReason::too_few_points,
         fmt::format("{} matches, need {}", update.matches, options_.min_points), update);
    return;
  }
  if (median_motion_px(shared, focal_px_) < options_.min_motion_px) {
    rest(update);
    return;
  }
  const auto pair = motion_of_pair(shared, current.position);
  if (const auto motion = motion_from_points(current, update)) {
    update.state = update.reason == OdometryReason::gap ? OdometryState::weak : OdometryState::tracking;
    accept(*motion, current);
    if (pair && pair->has_parallax) {
      move_on(std::move(current), *pair);
    } else if (update.reason == OdometryReason::none) {
      update.reason = pair ? OdometryReason::too_little_parallax : OdometryReason::few_inliers;
      update.detail = "k-1 stays";
    }
  } else if (!pair) {
    lose(std::move(current), OdometryReason::few_inliers, inliers_text(update.inliers, update.matches), update);
  } else if (pair->has_parallax) {
    follow_direction(std::move(current), *pair, update);
  } else {
    follow_rotation(shared, *pair, update);
  }
}

/// The camera stands where k-1 was.
void ThreeViewChain::rest(OdometryUpdate& update) {
  update.state = speed_ > 0.0 ? OdometryState::tracking : OdometryState::initializing;
  update.reason = OdometryReason::no_motion;
  update.inliers = update.matches;
  world_from_last_ = second_->world_from_camera;
  step_ = SE3();
  repeated_ = 0;
}

std::optional<ThreeViewChain::PairMotion> ThreeViewChain::motion_of_pair(const SharedRays& shared,
                                                                         std::size_t position) const {
  const auto fit = estimate_essential(shared.a, shared.b, ransac(options_.max_epipolar_error_px, 2 * position));
  const auto matches = static_cast<double>(shared.ids.size());
  if (!fit || fit->in_front < options_.min_points || fit->in_front < options_.min_inlier_share * matches)
    return std::nullopt;
  return PairMotion{fit->second_from_first, fit->median_parallax_deg >= options_.min_parallax_deg, fit->in_front};
}

/// second_from_current by P3P on the points of k-2 and k-1, in the unit of the trajectory.
std::optional<SE3> ThreeViewChain::motion_from_points(const View& current, OdometryUpdate& update) {
  if (points_.empty()) return std::nullopt;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (const KnownPoint& point : points_) {
    const Eigen::Vector2d* ray = find_ray(current.observations, point.id);
    if (!ray) continue;
    points.push_back(point.position);
    rays.push_back(*ray);
    located_.emplace_back(point.id, false);
  }
  update.matches = static_cast<int>(points.size());
  AbsolutePoseOptions options;
  static_cast<CalibratedRansacOptions&>(options) = ransac(options_.max_error_px, 2 * current.position + 1);
  options.refine_iterations = options_.refine_iterations;
  const auto fit = estimate_absolute_pose(points, rays, options);
  update.inliers = fit ? fit->inliers : 0;
  update.confidence = update.matches > 0 ? static_cast<double>(update.inliers) / update.matches : 0.0;
  if (!fit || fit->inliers < options_.min_points || update.confidence < options_.min_inlier_share) return std::nullopt;
  for (std::size_t i = 0; i < located_.size(); ++i) located_[i].second = fit->is_inlier[i] != 0;
  const SE3 second_from_current = second_from_first_ * fit->camera_from_world.inverse();
  const SE3 motion(second_from_current.rotation(), length_ * second_from_current.translation());
  const double distance = motion.translation().norm();
  return std::isfinite(distance) && distance > 0.0 ? std::optional(motion) : std::nullopt;
}

void ThreeViewChain::accept(const SE3& second_from_current, View& current) {
  const auto frames = static_cast<double>(current.position - second_->position);
  current.world_from_camera = world_from_last_ = second_->world_from_camera * second_from_current;
  step_ = interpolate(SE3(), second_from_current, 1.0 / frames);
  speed_ = second_from_current.translation().norm() / frames;
  repeated_ = 0;
}

/// k-1 becomes k-2, and k becomes k-1.
void ThreeViewChain::move_on(View current, const PairMotion& pair) {
  const TriangulationOptions options{focal_px_, options_.max_point_error_px, options_.min_point_parallax_deg};
  const SharedRays shared = shared_rays(second_->observations, current.observations);
  points_.clear();
  for (std::size_t i = 0; i < shared.ids.size(); ++i) {
    if (const auto point = triangulate(pair.second_from_first, shared.a[i], shared.b[i], options))
      points_.push_back({shared.ids[i], point->position});
  }
  second_from_first_ = pair.second_from_first;
  length_ = (current.world_from_camera.translation() - second_->world_from_camera.translation()).norm();
  second_ = std::move(current);
}

/// Without points: the direction of the pair, with the length of the last motion, or 1 for the first.
void ThreeViewChain::follow_direction(View current, const PairMotion& pair, OdometryUpdate& update) {
  const bool first = !(speed_ > 0.0);
  const std::size_t begin = second_->position;
  const auto frames = static_cast<double>(current.position - begin);
  const SE3 second_from_current = pair.second_from_first.inverse();
  const double length = first ? 1.0 : speed_ * frames;
  update.state = first ? OdometryState::tracking : OdometryState::weak;
  if (!first && update.reason == OdometryReason::none) {
    update.reason = OdometryReason::few_inliers;
    update.detail = inliers_text(update.inliers, update.matches) + "; length of the last motion";
  }
  if (first) update.inliers = pair.inliers;
  const SE3 from = second_->world_from_camera;
  accept(SE3(second_from_current.rotation(), length * second_from_current.translation()), current);
  // These frames got their poses before the translation was known.
  for (std::size_t i = begin + 1; i < current.position; ++i)
    trajectory_[i].world_from_body = interpolate(from, world_from_last_, static_cast<double>(i - begin) / frames);
  move_on(std::move(current), pair);
}

/// Without points and parallax: the rotation alone; k-1 stays.
void ThreeViewChain::follow_rotation(const SharedRays& shared, const PairMotion& pair, OdometryUpdate& update) {
  const bool started = speed_ > 0.0;
  const SO3 second_from_current = pair.second_from_first.rotation().inverse();
  const double rotation_px = focal_px_ * second_from_current.log().norm();
  update.state = started ? OdometryState::weak : OdometryState::initializing;
  if (update.reason == OdometryReason::none) {
    update.reason = 2.0 * rotation_px > median_motion_px(shared, focal_px_) ? OdometryReason::pure_rotation
                                                                            : OdometryReason::too_little_parallax;
    update.detail = fmt::format("median parallax below {} deg", options_.min_parallax_deg);
  }
  world_from_last_ = second_->world_from_camera * SE3(second_from_current, Eigen::Vector3d::Zero());
  step_ = SE3();
  repeated_ = 0;
  points_.clear();
}

void ThreeViewChain::lose(View current, OdometryReason reason, std::string detail, OdometryUpdate& update) {
  update.state = speed_ > 0.0 ? OdometryState::lost : OdometryState::initializing;
  if (update.reason == OdometryReason::none) {
    update.reason = reason;
    update.detail = std::move(detail);
  }
  repeat_motion();
  current.world_from_camera = world_from_last_;
  second_ = std::move(current);
  points_.clear();
}

void ThreeViewChain::repeat_motion() {
  if (++repeated_ <= options_.max_bridged_frames) world_from_last_ = world_from_last_ * step_;
}

}  // namespace rastro
