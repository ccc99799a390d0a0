// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/frame_tracker.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/feature/hamming.h"
#include "rastro/multiview/absolute_pose.h"

namespace rastro {
namespace {

constexpr double least_depth = 1e-6;

}  // namespace

FrameTracker::FrameTracker(const OrbSlamOptions& options, const Camera& camera, CameraKind sensor, double baseline)
    : options_(options),
      camera_(camera),
      sensor_(sensor),
      baseline_(baseline),
      level_scales_(orb_level_scales({.levels = options.levels, .scale_factor = options.scale_factor})) {}

void FrameTracker::set_view(std::shared_ptr<const MapView> view) {
  if (view_ && view) {
    std::int64_t common = view->find_keyframe(reference_) >= 0 ? view_->find_keyframe(reference_) : -1;
    for (std::int64_t i = static_cast<std::int64_t>(view_->keyframes.size()) - 1; i >= 0 && common < 0; --i) {
      if (view->find_keyframe(view_->keyframes[static_cast<std::size_t>(i)].id) >= 0) common = i;
    }
    if (common >= 0) {
      const MapView::Keyframe& before = view_->keyframes[static_cast<std::size_t>(common)];
      const MapView::Keyframe& now = view->keyframes[static_cast<std::size_t>(view->find_keyframe(before.id))];
      const double scale = now.unit / before.unit;
      const auto moved = [&](const SE3& pose) {
        const SE3 from_keyframe = pose * before.camera_from_world.inverse();
        return SE3(from_keyframe.rotation(), scale * from_keyframe.translation()) * now.camera_from_world;
      };
      const SE3 new_pose = moved(last_pose_), world_from_camera = new_pose.inverse();
      const auto follow = [&](Eigen::Vector3d& position) {
        position = world_from_camera * Eigen::Vector3d(scale * (last_pose_ * position));
      };
      for (TrackedPoint& point : last_points_) follow(point.position);
      for (Fresh& fresh : fresh_) {
        for (Eigen::Vector3d& position : fresh.positions) follow(position);
      }
      velocity_ = SE3(velocity_.rotation(), scale * velocity_.translation());
      last_pose_ = new_pose;
    }
  }
  view_ = std::move(view);
  if (!view_) return;
  std::erase_if(fresh_, [&](const Fresh& fresh) { return fresh.keyframe <= view_->latest; });
  for (TrackedPoint& point : last_points_) {
    const std::int64_t at = view_->find(point.landmark);
    if (at >= 0) point.position = view_->positions[static_cast<std::size_t>(at)];
  }
}

void FrameTracker::restart(const SE3& camera_from_world, std::vector<TrackedPoint> points,
                           std::shared_ptr<const FeatureFrame> frame) {
  last_pose_ = camera_from_world;
  velocity_ = SE3();
  reference_ = -1;
  last_points_ = std::move(points);
  last_frame_ = std::move(frame);
  fresh_.clear();
}

void FrameTracker::add_fresh(std::int64_t keyframe, std::shared_ptr<const FeatureFrame> frame,
                             const SE3& camera_from_world, const std::vector<std::uint32_t>& features) {
  Fresh fresh{keyframe, std::move(frame), features, {}};
  const SE3 world_from_camera = camera_from_world.inverse();
  for (const std::uint32_t feature : features)
    fresh.positions.push_back(world_from_camera * fresh.frame->point(feature));
  fresh_.push_back(std::move(fresh));
}

void FrameTracker::expect(const FeatureFrame& frame, const Eigen::Vector3d& in_camera, int level, int reach,
                          float radius, const Descriptor& descriptor, const TrackedPoint& subject,
                          Search& search) const {
  const double inverse = 1.0 / in_camera.z();
  const auto x = static_cast<float>(camera_.fx * in_camera.x() * inverse + camera_.cx);
  const auto y = static_cast<float>(camera_.fy * in_camera.y() * inverse + camera_.cy);
  if (!frame.holds(x, y)) return;
  const int last = options_.levels - 1;
  level = std::clamp(level, 0, last);
  const float right = baseline_ > 0.0 ? static_cast<float>(x - camera_.fx * baseline_ * inverse) : std::nanf("");
  search.expected.push_back({static_cast<std::uint32_t>(search.subjects.size()), x, y,
                             radius * static_cast<float>(level_scales_[static_cast<std::size_t>(level)]), right,
                             static_cast<std::uint8_t>(std::max(0, level - reach)),
                             static_cast<std::uint8_t>(std::min(last, level + reach)), &descriptor});
  search.subjects.push_back(subject);
}

PoseRefinement FrameTracker::refine(const FeatureFrame& frame, const Search& search,
                                    const std::vector<FeatureMatch>& matches, const SE3& start) const {
  std::vector<PoseObservation> observations;
  observations.reserve(matches.size());
  for (const FeatureMatch& match : matches) {
    PoseObservation o;
    o.point = search.subjects[match.subject].position;
    o.ray = frame.ray(match.feature);
    o.right_x = frame.right_ray(match.feature);
    o.sigma = options_.pixel_sigma * level_scales_[frame.level(match.feature)] / camera_.fx;
    observations.push_back(o);
  }
  return refine_pose(start, observations, {.baseline = baseline_});
}

PoseRefinement FrameTracker::guess_pose(const FeatureFrame& frame, const SE3& start, float radius) const {
  Search search;
  for (const TrackedPoint& point : last_points_) {
    const Eigen::Vector3d in_camera = start * point.position;
    if (in_camera.z() < least_depth) continue;
    expect(frame, in_camera, last_frame_->level(point.feature), 1, radius, last_frame_->descriptor(point.feature),
           point, search);
  }
  const auto matches =
      match_expected(frame, search.expected, {.max_distance = options_.match_hamming, .max_ratio = 1.0});
  return refine(frame, search, matches, start);
}

std::optional<SE3> FrameTracker::pose_by_reference(const FeatureFrame& frame) const {
  const std::int64_t at = view_->find_keyframe(reference_ >= 0 ? reference_ : view_->centre);
  if (at < 0) return std::nullopt;
  Search search;
  for (std::size_t i = 0; i < view_->size(); ++i) {
    const auto begin = view_->seen_by.begin() + view_->seen_begin[i],
               end = view_->seen_by.begin() + view_->seen_begin[i + 1];
    if (std::find(begin, end, static_cast<std::uint32_t>(at)) == end) continue;
    search.expected.push_back({static_cast<std::uint32_t>(search.subjects.size()), static_cast<float>(camera_.cx),
                               static_cast<float>(camera_.cy), 1e6F, std::nanf(""), 0,
                               static_cast<std::uint8_t>(options_.levels - 1), &view_->descriptors[i]});
    TrackedPoint point;
    point.landmark = view_->ids[i];
    point.position = view_->positions[i];
    search.subjects.push_back(point);
  }
  const auto matches = match_expected(frame, search.expected,
                                      {.max_distance = options_.init_hamming, .max_ratio = options_.match_ratio});
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (const FeatureMatch& match : matches) {
    points.push_back(search.subjects[match.subject].position);
    rays.push_back(frame.ray(match.feature));
  }
  AbsolutePoseOptions options;
  options.focal_px = camera_.fx;
  options.max_iterations = options_.pnp_iterations;
  options.max_error_px = 4.0;
  options.seed = options_.seed;
  const auto pose = estimate_absolute_pose(points, rays, options, last_pose_);
  if (!pose || pose->inliers < options_.min_guess_inliers / 2) return std::nullopt;
  return pose->camera_from_world;
}

void FrameTracker::expect_landmarks(const FeatureFrame& frame, const SE3& pose, Search& search,
                                    std::vector<std::int64_t>& visible) const {
  const Eigen::Matrix3d rotation = pose.rotation().matrix();
  const Eigen::Vector3d centre = pose.inverse().translation();
  const double least_cosine = std::cos(options_.max_view_angle_deg * M_PI / 180.0);
  const double log_scale = std::log(options_.scale_factor);
  for (std::size_t i = 0; i < view_->size(); ++i) {
    const Eigen::Vector3d in_camera = rotation * view_->positions[i] + pose.translation();
    if (in_camera.z() < least_depth) continue;
    const Eigen::Vector3d way = view_->positions[i] - centre;
    const double distance = way.norm();
    if (distance < 0.8 * static_cast<double>(view_->min_distances[i]) ||
        distance > 1.25 * static_cast<double>(view_->max_distances[i]))
      continue;
    if (way.dot(view_->directions[i]) < least_cosine * distance) continue;
    const int level = static_cast<int>(
        std::ceil(std::log(static_cast<double>(view_->max_distances[i]) / distance) / log_scale - 0.5));
    TrackedPoint point;
    point.landmark = view_->ids[i];
    point.position = view_->positions[i];
    const std::size_t before = search.subjects.size();
    expect(frame, in_camera, level, 1, static_cast<float>(options_.local_search_px), view_->descriptors[i], point,
           search);
    if (search.subjects.size() > before) visible.push_back(view_->ids[i]);
  }
}

void FrameTracker::expect_fresh(const FeatureFrame& frame, const SE3& pose, Search& search) const {
  for (const Fresh& fresh : fresh_) {
    for (std::size_t i = 0; i < fresh.features.size(); ++i) {
      const Eigen::Vector3d in_camera = pose * fresh.positions[i];
      if (in_camera.z() < least_depth) continue;
      TrackedPoint point;
      point.keyframe = fresh.keyframe;
      point.keyframe_feature = fresh.features[i];
      point.position = fresh.positions[i];
      expect(frame, in_camera, fresh.frame->level(fresh.features[i]), 1, static_cast<float>(options_.local_search_px),
             fresh.frame->descriptor(fresh.features[i]), point, search);
    }
  }
}

TrackResult FrameTracker::track_local(const FeatureFrame& frame, const SE3& guess) const {
  Search search;
  TrackResult result;
  expect_landmarks(frame, guess, search, result.visible);
  expect_fresh(frame, guess, search);
  const auto matches = match_expected(frame, search.expected,
                                      {.max_distance = options_.match_hamming, .max_ratio = options_.match_ratio});
  const PoseRefinement refined = refine(frame, search, matches, guess);
  result.matches = static_cast<int>(matches.size());
  result.inliers = refined.inliers;
  result.camera_from_world = refined.camera_from_world;
  result.covariance = refined.covariance;
  result.mean_squared = refined.mean_squared;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (refined.is_inlier[i] == 0) continue;
    result.points.push_back(search.subjects[matches[i].subject]);
    result.points.back().feature = matches[i].feature;
  }
  result.reference = reference_of(result.points);
  return result;
}

std::int64_t FrameTracker::reference_of(const std::vector<TrackedPoint>& points) const {
  std::vector<int> shared(view_->keyframes.size(), 0);
  for (const TrackedPoint& point : points) {
    const std::int64_t i = view_->find(point.landmark);
    if (i < 0) continue;
    const auto at = static_cast<std::size_t>(i);
    for (std::uint32_t k = view_->seen_begin[at]; k < view_->seen_begin[at + 1]; ++k) ++shared[view_->seen_by[k]];
  }
  std::size_t best = 0;
  for (std::size_t k = 0; k < shared.size(); ++k) {
    if (shared[k] >= shared[best]) best = k;
  }
  return view_->keyframes.empty() ? -1 : view_->keyframes[best].id;
}

PoseRefinement FrameTracker::pose_by_tracks(const std::vector<FollowedLandmark>& followed) const {
  std::vector<PoseObservation> observations;
  for (const FollowedLandmark& seen : followed) {
    const std::int64_t at = view_->find(seen.landmark);
    if (at < 0) continue;
    PoseObservation o;
    o.point = view_->positions[static_cast<std::size_t>(at)];
    o.ray = seen.ray;
    o.sigma = options_.pixel_sigma / camera_.fx;
    observations.push_back(o);
  }
  return refine_pose(predicted(), observations, {.baseline = baseline_});
}

PoseRefinement FrameTracker::guess(const FeatureFrame& frame, const std::vector<FollowedLandmark>& followed) const {
  if (!followed.empty()) {
    PoseRefinement by_tracks = pose_by_tracks(followed);
    if (by_tracks.inliers >= options_.min_guess_inliers) return by_tracks;
  }
  const auto radius = static_cast<float>(options_.search_px);
  PoseRefinement found = guess_pose(frame, predicted(), radius);
  if (found.inliers < options_.min_guess_inliers) found = guess_pose(frame, predicted(), 2.5F * radius);
  if (found.inliers < options_.min_guess_inliers) found = guess_pose(frame, last_pose_, 4.0F * radius);
  return found;
}

TrackResult FrameTracker::track(const std::shared_ptr<const FeatureFrame>& frame,
                                const std::vector<FollowedLandmark>& followed) {
  const PoseRefinement guessed = guess(*frame, followed);
  SE3 start = guessed.camera_from_world;
  if (guessed.inliers < options_.min_guess_inliers) {
    if (const auto pose = pose_by_reference(*frame)) start = *pose;
  }
  TrackResult result = track_local(*frame, start);
  result.guessed = guessed.inliers;
  result.ok = result.inliers >= options_.min_inliers;
  if (result.ok) accept(frame, result);
  return result;
}

TrackResult FrameTracker::track_from(const std::shared_ptr<const FeatureFrame>& frame, const SE3& camera_from_world) {
  TrackResult result = track_local(*frame, camera_from_world);
  result.ok = result.inliers >= options_.min_inliers;
  if (result.ok) {
    accept(frame, result);
    velocity_ = SE3();
  }
  return result;
}

void FrameTracker::accept(const std::shared_ptr<const FeatureFrame>& frame, const TrackResult& result) {
  velocity_ = result.camera_from_world * last_pose_.inverse();
  last_pose_ = result.camera_from_world;
  last_points_ = result.points;
  last_frame_ = frame;
  reference_ = result.reference;
}

}  // namespace rastro
