// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/feature_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "rastro/feature/distance_grid.h"

namespace rastro {
namespace {

constexpr int pyramid_levels = 5;
constexpr int points_per_chunk = 32;
// The pose that guides the matching is accurate to a few pixels.
constexpr double recognition_reach_px = 5.0;
constexpr int border_px = 4;
// A patch stretched or shrunk by more than this shows other detail.
constexpr float max_scale = 1.6F;
// Two points this much closer than the minimum distance are the same corner, detected twice.
constexpr double same_share = 0.5;

bool inside(const Camera& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= border_px && pixel.y() >= border_px && pixel.x() < camera.width - border_px &&
         pixel.y() < camera.height - border_px;
}

}  // namespace

struct FeatureTracker::Candidate {
  std::size_t point = 0;
  Eigen::Vector2f guess;
  Eigen::Matrix2f current_from_anchor;
  const FoundPoint* carried = nullptr;
};

KltOptions FeatureTracker::flow_options() const {
  KltOptions options;
  options.window_px = options_.patch_px;
  options.iterations = 15;
  options.epsilon_px = 0.02;
  options.coarse_epsilon_px = 0.1;
  options.backward_levels = 0;  // matching with the anchor's patch finds drifted points
  return options;
}

void FeatureTracker::take(const Frame& frame) {
  std::swap(previous_, current_);
  current_.build(frame.image.view(), pyramid_levels, klt_padding, pool_);
}

std::vector<FoundPoint> FeatureTracker::carry_on(const PointMap& map, const SE3& guess) const {
  std::vector<std::size_t> indices;
  std::vector<Eigen::Vector2f> from, to;
  const SE3 camera_from_world = guess.inverse();
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    if (!map.points[i].tracked) continue;
    const auto pixel = camera_.project(camera_from_world * map.in_world(map.points[i]));
    if (!pixel || !inside(camera_, *pixel)) continue;
    indices.push_back(i);
    from.push_back(map.points[i].pixel);
    to.push_back(pixel->cast<float>());
  }
  std::vector<KltResult> results(indices.size());
  if (previous_.levels() > 0) klt_follow(previous_, current_, from, to, flow_options(), pool_, results);
  std::vector<FoundPoint> found;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (!results[i].followed) continue;
    const auto ray = camera_.unproject(results[i].pixel.cast<double>());
    if (ray) found.push_back({indices[i], results[i].pixel, *ray, false});
  }
  return found;
}

std::vector<FeatureTracker::Candidate> FeatureTracker::in_view(const PointMap& map, const SE3& pose,
                                                               const std::vector<FoundPoint>& carried) const {
  std::vector<const FoundPoint*> carried_of(map.points.size(), nullptr);
  for (const FoundPoint& found : carried) carried_of[found.point] = &found;
  const SE3 camera_from_world = pose.inverse();
  std::vector<SE3> camera_from_anchor(map.references.size());
  for (std::size_t i = 0; i < map.references.size(); ++i)
    camera_from_anchor[i] = camera_from_world * map.references[i].world_from_camera;
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const MapPoint& point = map.points[i];
    const SE3& camera_from = camera_from_anchor[static_cast<std::size_t>(point.anchor)];
    const double depth = 1.0 / point.inverse_depth;
    const Eigen::Vector3d p = camera_from * Eigen::Vector3d(depth * point.ray.x(), depth * point.ray.y(), depth);
    Eigen::Matrix<double, 2, 3> projection;
    const auto pixel = camera_.project(p, projection);
    if (!pixel || p.z() < 0.05 || !inside(camera_, *pixel)) continue;
    // Local motion of the anchor's image: the derivative for a surface that faces the anchor.
    const Eigen::Matrix<double, 3, 2> across =
        camera_from.rotation().matrix().leftCols<2>() *
        (Eigen::Vector2d(1.0 / camera_.fx, 1.0 / camera_.fy) * depth).asDiagonal();
    const Eigen::Matrix2f warp = (projection * across).cast<float>();
    const float scale = std::sqrt(std::abs(warp.determinant()));
    if (!(scale < max_scale && scale > 1.0F / max_scale)) continue;
    candidates.push_back({i, pixel->cast<float>(), warp, carried_of[i]});
  }
  return candidates;
}

std::vector<FoundPoint> FeatureTracker::recognize(PointMap& map, const SE3& pose,
                                                  const std::vector<FoundPoint>& carried) {
  const std::vector<Candidate> candidates = in_view(map, pose, carried);
  const KltOptions options = flow_options();
  std::vector<KltResult> results(candidates.size());
  const auto align = [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto k = static_cast<std::size_t>(i);
      results[k] = map.points[candidates[k].point].patch.align(current_, candidates[k].guess, recognition_reach_px,
                                                               options, candidates[k].current_from_anchor);
    }
  };
  const int count = static_cast<int>(candidates.size());
  pool_ ? pool_->for_chunks(0, count, points_per_chunk, align) : align(0, count);
  for (MapPoint& point : map.points) point.tracked = false;
  DistanceGrid grid(camera_.width, camera_.height, same_share * options_.min_distance_px);
  std::vector<FoundPoint> found;
  // Points are in the order of their anchors.
  for (std::size_t i = 0; i < candidates.size() && static_cast<int>(found.size()) < options_.features; ++i) {
    MapPoint& point = map.points[candidates[i].point];
    const FoundPoint* before = candidates[i].carried;
    const bool recognized = results[i].followed;
    if (!recognized) ++point.missed;
    if (!recognized && !before) continue;
    FoundPoint here{candidates[i].point, recognized ? results[i].pixel : before->pixel, {}, recognized};
    const auto ray = camera_.unproject(here.pixel.cast<double>());
    if (!ray || !inside(camera_, here.pixel.cast<double>()) || !grid.add_if_far(here.pixel.x(), here.pixel.y()))
      continue;
    here.ray = *ray;
    point.tracked = true;
    point.pixel = here.pixel;
    if (recognized) point.missed = 0;
    found.push_back(here);
  }
  return found;
}

std::vector<Eigen::Vector2f> FeatureTracker::new_corners(const Frame& frame, const std::vector<FoundPoint>& found,
                                                         int count) {
  const int width = frame.image.width(), height = frame.image.height();
  const bool masked = frame.mask.width() == width && frame.mask.height() == height;
  free_ = masked ? frame.mask : GrayImage(width, height);
  if (!masked) {
    for (int y = 0; y < height; ++y) std::fill_n(free_.row(y), width, std::uint8_t{255});
  }
  const int reach = static_cast<int>(options_.min_distance_px);
  for (const FoundPoint& point : found) {
    const int cx = static_cast<int>(point.pixel.x()), cy = static_cast<int>(point.pixel.y());
    const int left = std::max(0, cx - reach), right = std::min(width - 1, cx + reach);
    for (int y = std::max(0, cy - reach); y <= std::min(height - 1, cy + reach) && left <= right; ++y)
      std::fill_n(free_.row(y) + left, right - left + 1, std::uint8_t{0});
  }
  CornerOptions options;
  options.quality = 0.005;
  options.min_distance_px = options_.min_distance_px;
  options.border_px = options_.patch_px / 2 + border_px;
  std::vector<Eigen::Vector2f> corners;
  for (const Corner& corner : detector_.detect(current_.level(0), free_.view(), count, options, pool_))
    corners.emplace_back(static_cast<float>(corner.x), static_cast<float>(corner.y));
  return corners;
}

}  // namespace rastro
