// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/frame_tracker.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/feature/hamming.h"
#include "rastro/multiview/absolute_pose.h"

namespace rastro {
namespace {

TrackedPoint landmark_point(const MapView& view, std::size_t landmark) {
  TrackedPoint point;
  point.landmark = view.ids[landmark];
  point.position = view.positions[landmark];
  return point;
}

}  // namespace

FrameTracker::FrameTracker(const OrbSlamOptions& options, const Camera& camera, CameraKind sensor, double baseline)
    : options_(options),
      camera_(camera),
      sensor_(sensor),
      baseline_(baseline),
      level_scales_(orb_level_scales({.levels = options.levels, .scale_factor = options.scale_factor})) {}

void FrameTracker::set_view(std::shared_ptr<const MapView> view) {
  if (view_ && view) move_to(*view);
  view_ = std::move(view);
  if (!view_) return;
  std::erase_if(depth_points_, [&](const DepthPoints& points) { return points.keyframe <= view_->latest; });
  for (TrackedPoint& point : last_points_) {
    const std::int64_t at = view_->find(point.landmark);
    if (at >= 0) point.position = view_->positions[static_cast<std::size_t>(at)];
  }
}

/// The reference keyframe, else the newest that is in both views; index in the old one, -1: none.
std::int64_t FrameTracker::common_keyframe(const MapView& view) const {
  std::int64_t common = view.find_keyframe(reference_) >= 0 ? view_->find_keyframe(reference_) : -1;
  for (std::int64_t i = static_cast<std::int64_t>(view_->keyframes.size()) - 1; i >= 0 && common < 0; --i) {
    if (view.find_keyframe(view_->keyframes[static_cast<std::size_t>(i)].id) >= 0) common = i;
  }
  return common;
}

/// Pose and points keep their pose and scale relative to a keyframe that is in both views.
void FrameTracker::move_to(const MapView& view) {
  const std::int64_t common = common_keyframe(view);
  if (common < 0) return;
  const MapView::Keyframe& before = view_->keyframes[static_cast<std::size_t>(common)];
  const MapView::Keyframe& now = view.keyframe(before.id);
  const double scale = now.unit / before.unit;
  const SE3 from_keyframe = last_pose_ * before.camera_from_world.inverse();
  const SE3 new_pose = SE3(from_keyframe.rotation(), scale * from_keyframe.translation()) * now.camera_from_world;
  const SE3 world_from_camera = new_pose.inverse();
  const auto move = [&](Eigen::Vector3d& position) {
    position = world_from_camera * Eigen::Vector3d(scale * (last_pose_ * position));
  };
  for (TrackedPoint& point : last_points_) move(point.position);
  for (DepthPoints& points : depth_points_) {
    for (Eigen::Vector3d& position : points.positions) move(position);
  }
  velocity_ = SE3(velocity_.rotation(), scale * velocity_.translation());
  last_pose_ = new_pose;
}

void FrameTracker::restart(const SE3& camera_from_world, std::vector<TrackedPoint> points,
                           std::shared_ptr<const FeatureFrame> frame) {
  last_pose_ = camera_from_world;
  velocity_ = SE3();
  reference_ = -1;
  last_points_ = std::move(points);
  last_frame_ = std::move(frame);
  depth_points_.clear();
}

void FrameTracker::add_depth_points(std::int64_t keyframe, std::shared_ptr<const FeatureFrame> frame,
                                    const SE3& camera_from_world, const std::vector<std::uint32_t>& features) {
  DepthPoints fresh{keyframe, std::move(frame), features, {}};
  const SE3 world_from_camera = camera_from_world.inverse();
  for (const std::uint32_t feature : features)
    fresh.positions.push_back(world_from_camera * fresh.frame->point(feature));
  depth_points_.push_back(std::move(fresh));
}

FrameTracker::Search FrameTracker::search_in(const FeatureFrame& frame, float radius_px) const {
  std::vector<float> radii;
  for (const double scale : level_scales_) radii.push_back(radius_px * static_cast<float>(scale));
  const GuidedSearchOptions options{.baseline = baseline_,
                                    .scale_factor = options_.scale_factor,
                                    .min_view_cosine = std::cos(options_.max_view_angle_deg * M_PI / 180.0)};
  return {GuidedSearch(camera_, frame.grid(), std::move(radii), options), {}};
}

const Eigen::Matrix3d* FrameTracker::covariance_of(std::int64_t landmark) const {
  if (view_->covariances.empty()) return nullptr;
  const std::int64_t at = view_->find(landmark);
  return at >= 0 ? &view_->covariances[static_cast<std::size_t>(at)] : nullptr;
}

PoseRefinement FrameTracker::refine(const FeatureFrame& frame, const Search& search,
                                    const std::vector<FeatureMatch>& matches, const SE3& start,
                                    bool starts_judged) const {
  std::vector<PoseObservation> observations;
  observations.reserve(matches.size());
  for (const FeatureMatch& match : matches) {
    PoseObservation o;
    o.point = search.points[match.subject].position;
    o.ray = frame.ray(match.feature);
    o.right_x = frame.right_ray(match.feature);
    o.sigma = options_.pixel_sigma * level_scales_[frame.level(match.feature)] / camera_.fx;
    o.point_covariance = covariance_of(search.points[match.subject].landmark);
    observations.push_back(o);
  }
  PoseRefinementOptions options{.baseline = baseline_};
  options.starts_judged = starts_judged;
  if (starts_judged) options.rounds = 2;
  return refine_pose(start, observations, options);
}

/// Matches the points of the last frame, projected with a predicted pose.
PoseRefinement FrameTracker::pose_by_last_frame(const FeatureFrame& frame, const SE3& start, float radius_px) const {
  Search search = search_in(frame, radius_px);
  for (const TrackedPoint& point : last_points_) {
    if (search.windows.add_point(static_cast<std::uint32_t>(search.points.size()), start * point.position,
                                 last_frame_->level(point.feature), last_frame_->descriptor(point.feature)))
      search.points.push_back(point);
  }
  const auto matches = search.windows.match({.max_distance = options_.match_hamming, .max_ratio = 1.0});
  return refine(frame, search, matches, start);
}

/// Matches landmarks of the reference keyframe, without a predicted position.
std::optional<SE3> FrameTracker::pose_by_reference(const FeatureFrame& frame) const {
  const std::int64_t at = view_->find_keyframe(reference_ >= 0 ? reference_ : view_->center);
  if (at < 0) return std::nullopt;
  Search search = search_in(frame, 0.0F);
  for (std::size_t i = 0; i < view_->size(); ++i) {
    const auto begin = view_->seen_by.begin() + view_->seen_begin[i],
               end = view_->seen_by.begin() + view_->seen_begin[i + 1];
    if (std::find(begin, end, static_cast<std::uint32_t>(at)) == end) continue;
    search.windows.add_anywhere(static_cast<std::uint32_t>(search.points.size()), view_->descriptors[i]);
    search.points.push_back(landmark_point(*view_, i));
  }
  const auto matches = search.windows.match({.max_distance = options_.init_hamming, .max_ratio = options_.match_ratio});
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (const FeatureMatch& match : matches) {
    points.push_back(search.points[match.subject].position);
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

void FrameTracker::add_landmarks(const SE3& pose, Search& search, std::vector<std::int64_t>& visible) const {
  const MapView& view = *view_;
  const Eigen::Matrix3d rotation = pose.rotation().matrix();
  const Eigen::Vector3d center = pose.inverse().translation();
  for (std::size_t i = 0; i < view.size(); ++i) {
    const Eigen::Vector3d in_camera = rotation * view.positions[i] + pose.translation();
    const LandmarkAppearance landmark{view.positions[i], view.directions[i], view.min_distances[i],
                                      view.max_distances[i], view.descriptors[i]};
    if (!search.windows.add_landmark(static_cast<std::uint32_t>(search.points.size()), landmark, in_camera, center))
      continue;
    search.points.push_back(landmark_point(view, i));
    visible.push_back(view.ids[i]);
  }
}

void FrameTracker::add_depth_points(const SE3& pose, Search& search) const {
  for (const DepthPoints& points : depth_points_) {
    for (std::size_t i = 0; i < points.features.size(); ++i) {
      const std::uint32_t feature = points.features[i];
      if (!search.windows.add_point(static_cast<std::uint32_t>(search.points.size()), pose * points.positions[i],
                                    points.frame->level(feature), points.frame->descriptor(feature)))
        continue;
      TrackedPoint point;
      point.keyframe = points.keyframe;
      point.keyframe_feature = feature;
      point.position = points.positions[i];
      search.points.push_back(point);
    }
  }
}

TrackingResult FrameTracker::track_local_map(const FeatureFrame& frame, const SE3& predicted) const {
  Search search = search_in(frame, static_cast<float>(options_.local_search_px));
  TrackingResult result;
  add_landmarks(predicted, search, result.visible);
  add_depth_points(predicted, search);
  const auto matches =
      search.windows.match({.max_distance = options_.match_hamming, .max_ratio = options_.match_ratio});
  PoseRefinement refined = refine(frame, search, matches, predicted);
  if (auto established = refine_by_established(frame, search, matches, refined)) refined = std::move(*established);
  result.matches = static_cast<int>(matches.size());
  result.inliers = refined.inliers;
  result.camera_from_world = refined.camera_from_world;
  result.covariance = refined.covariance;
  result.mean_squared = refined.mean_squared;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    std::vector<TrackedPoint>& points = refined.is_inlier[i] != 0 ? result.points : result.outliers;
    points.push_back(search.points[matches[i].subject]);
    points.back().feature = matches[i].feature;
  }
  result.supporting = supporting(result.camera_from_world, result.points);
  result.reference = reference_of(result.points);
  return result;
}

/// In a map that nothing corrects any more, far landmarks that were hardly triangulated tell the rotation, but not how
/// far the camera has come: their errors have one cause, the keyframes that saw them, and do not average out.
int FrameTracker::supporting(const SE3& camera_from_world, const std::vector<TrackedPoint>& points) const {
  const Eigen::Vector3d center = camera_from_world.inverse().translation();
  const auto supports = [&](const TrackedPoint& point) {
    const Eigen::Matrix3d* covariance = covariance_of(point.landmark);
    if (covariance == nullptr || options_.localization_distance_error <= 0.0) return true;
    const Eigen::Vector3d from_camera = point.position - center;
    const double limit = options_.localization_distance_error * from_camera.squaredNorm();
    return from_camera.dot(*covariance * from_camera) <= limit * limit;
  };
  return static_cast<int>(std::count_if(points.begin(), points.end(), supports));
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

PoseRefinement FrameTracker::pose_by_tracks(const std::vector<LandmarkTrack>& tracks) const {
  std::vector<PoseObservation> observations;
  for (const LandmarkTrack& track : tracks) {
    const std::int64_t at = view_->find(track.landmark);
    if (at < 0) continue;
    PoseObservation o;
    o.point = view_->positions[static_cast<std::size_t>(at)];
    o.ray = track.ray;
    o.sigma = options_.pixel_sigma / camera_.fx;
    o.point_covariance = covariance_of(track.landmark);
    observations.push_back(o);
  }
  return refine_pose(predicted(), observations, {.baseline = baseline_});
}

PoseRefinement FrameTracker::predict_pose(const FeatureFrame& frame, const std::vector<LandmarkTrack>& tracks) const {
  if (!tracks.empty()) {
    PoseRefinement by_tracks = pose_by_tracks(tracks);
    if (by_tracks.inliers >= options_.min_guess_inliers) return by_tracks;
  }
  const auto radius = static_cast<float>(options_.search_px);
  PoseRefinement found = pose_by_last_frame(frame, predicted(), radius);
  if (found.inliers < options_.min_guess_inliers) found = pose_by_last_frame(frame, predicted(), 2.5F * radius);
  if (found.inliers < options_.min_guess_inliers) found = pose_by_last_frame(frame, last_pose_, 4.0F * radius);
  return found;
}

TrackingResult FrameTracker::track(const std::shared_ptr<const FeatureFrame>& frame,
                                   const std::vector<LandmarkTrack>& tracks) {
  const PoseRefinement predicted = predict_pose(*frame, tracks);
  SE3 start = predicted.camera_from_world;
  if (predicted.inliers < options_.min_guess_inliers) {
    if (const auto pose = pose_by_reference(*frame)) start = *pose;
  }
  TrackingResult result = track_local_map(*frame, start);
  result.predicted = predicted.inliers;
  result.ok = result.supporting >= options_.min_inliers && exceeds_chance(*frame, result);
  if (result.ok) accept(frame, result);
  return result;
}

TrackingResult FrameTracker::track_from(const std::shared_ptr<const FeatureFrame>& frame,
                                        const SE3& camera_from_world) {
  TrackingResult result = track_local_map(*frame, camera_from_world);
  result.ok = result.supporting >= options_.min_inliers;
  if (result.ok) {
    accept(frame, result);
    velocity_ = SE3();
  }
  return result;
}

void FrameTracker::correct(const SE3& camera_from_world) {
  velocity_ = camera_from_world * last_pose_.inverse() * velocity_;
  last_pose_ = camera_from_world;
}

void FrameTracker::accept(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& result) {
  velocity_ = result.camera_from_world * last_pose_.inverse();
  last_pose_ = result.camera_from_world;
  last_points_ = result.points;
  last_frame_ = frame;
  reference_ = result.reference;
}

}  // namespace rastro
