// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/fusion/view_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "rastro/odometry/rgbd_tracking/depth_reading.h"

namespace rastro {
namespace {

constexpr int levels = 2;             // both sides are close by then
constexpr double min_gradient = 3.0;  // levels per pixel
constexpr int cell_px = 8;            // of which the strongest pixel with a depth is a point
constexpr int surface_step = 3, surface_iterations = 3;
constexpr double surface_reach_m = 0.03, overlap_reach_m = 0.1;
constexpr double least_overlap = 0.15;  // of the view's surfaces with the keyframe's
constexpr double loose_sigma = 0.03;    // meters and radians: of a guess, where images do not align
constexpr int least_blocks = 50;        // compared, of every surface_step-th

int squared_gradient(const PaddedImage& image, int x, int y) {
  const int across = image.row(y)[x + 1] - image.row(y)[x - 1], down = image.row(y + 1)[x] - image.row(y - 1)[x];
  return across * across + down * down;
}

/// The pixel of a cell with the largest gradient; nullopt where none is large enough.
std::optional<Eigen::Vector2i> strongest_pixel(const PaddedImage& image, int left, int top) {
  constexpr int least = static_cast<int>(4.0 * min_gradient * min_gradient);
  std::optional<Eigen::Vector2i> best;
  int most = least;
  for (int y = std::max(1, top); y < std::min(top + cell_px, image.height() - 1); ++y)
    for (int x = std::max(1, left); x < std::min(left + cell_px, image.width() - 1); ++x) {
      const int squared = squared_gradient(image, x, y);
      if (squared < most) continue;
      most = squared + 1;
      best = Eigen::Vector2i(x, y);
    }
  return best;
}

Matrix6d symmetric(const Matrix6d& matrix) { return 0.5 * (matrix + matrix.transpose()); }

}  // namespace

std::size_t AlignedView::bytes() const {
  std::size_t pixels = 0, floats = planes.size() * 4 + blocks.depth.size();
  for (int level = 0; level < image.levels(); ++level)
    pixels += static_cast<std::size_t>(image.level(level).stride()) *
              static_cast<std::size_t>(image.level(level).height() + 2 * image.level(level).padding());
  for (int level = 0; level < points.levels(); ++level)
    floats += 7 * static_cast<std::size_t>(points.level(level).count);
  pixels += static_cast<std::size_t>(right.width()) * static_cast<std::size_t>(right.height());
  floats += static_cast<std::size_t>(depth.width()) * static_cast<std::size_t>(depth.height());
  return sizeof(AlignedView) + pixels + floats * sizeof(float);
}

ViewAlignment::ViewAlignment(const FusionOptions& options, const SensorChoice& sensor)
    : options_(options),
      sensor_(sensor),
      undistorted_(single_camera(sensor.camera), levels, nullptr),
      camera_(single_camera(sensor.camera).camera) {
  if (sensor.sensor == CameraKind::depth) {
    surfaces_.emplace(sensor.camera, SurfaceOptions{options.depth_sigma_m, options.depth_sigma_per_m2,
                                                    options.min_depth_m, options.max_depth_m});
  } else {
    const double focal_times_baseline = sensor.camera.fx * sensor.baseline;
    stereo_.emplace(
        StereoDepthOptions{focal_times_baseline, options.stereo_min_disparity_px, options.stereo_max_disparity_px});
    options_.depth_sigma_m = 0.0;
    options_.depth_sigma_per_m2 = options.stereo_sigma_px / focal_times_baseline;
    options_.min_depth_m = focal_times_baseline / options.stereo_max_disparity_px;
    options_.max_depth_m = focal_times_baseline / options.stereo_min_disparity_px;
  }
  image_options_.coarsest_level = levels - 1;
  image_options_.noise.intensity_sigma = options.intensity_sigma;
}

std::shared_ptr<const DirectView> ViewAlignment::view_of(const Frame& frame, const SE3& depth_from_color) const {
  if (frame.image.width() != sensor_.camera.width || frame.image.height() != sensor_.camera.height) return nullptr;
  auto view = std::make_shared<AlignedView>();
  view->image = undistorted_.make(frame).pyramid;
  view->right = frame.right;
  view->depth_from_color = depth_from_color;
  if (!surfaces_ || frame.depth.width() != frame.image.width() || frame.depth.height() != frame.image.height())
    return view;
  view->depth = frame.depth;
  view->blocks = depth_blocks(
      frame.depth, frame.mask.view(),
      SurfaceOptions{options_.depth_sigma_m, options_.depth_sigma_per_m2, options_.min_depth_m, options_.max_depth_m});
  return view;
}

/// Of the strongest pixel in each cell.
InverseDepthMap ViewAlignment::depths_of(const AlignedView& view) const {
  RgbdOptions reading;
  reading.depth_sigma_m = options_.depth_sigma_m;
  reading.depth_sigma_per_m2 = options_.depth_sigma_per_m2;
  reading.min_depth_m = options_.min_depth_m;
  reading.max_depth_m = options_.max_depth_m;
  const PaddedImage& image = view.image.level(0);
  const DepthImage depth =
      stereo_ && !view.right.empty() ? stereo_->depth(image.view(), view.right.view()) : view.depth;
  InverseDepthMap known(image.width(), image.height());
  if (depth.empty()) return known;
  for (int top = 0; top < image.height(); top += cell_px)
    for (int left = 0; left < image.width(); left += cell_px) {
      const auto pixel = strongest_pixel(image, left, top);
      if (!pixel) continue;
      const Eigen::Vector2d ray((pixel->x() - camera_.cx) / camera_.fx, (pixel->y() - camera_.cy) / camera_.fy);
      const auto measured = read_depth(depth, sensor_.camera, ray, view.depth_from_color, reading);
      if (!measured) continue;
      known.mean.at(pixel->x(), pixel->y()) = static_cast<float>(measured->inverse_depth);
      known.variance.at(pixel->x(), pixel->y()) = static_cast<float>(measured->sigma * measured->sigma);
    }
  return known;
}

std::shared_ptr<const DirectView> ViewAlignment::keyframe_of(const DirectView& any) const {
  const auto& view = static_cast<const AlignedView&>(any);
  auto keyframe = std::make_shared<AlignedView>(view);
  AlignmentReferenceOptions points;
  points.levels = levels;
  points.min_gradient = min_gradient;
  points.max_points = options_.direct_points;
  keyframe->points.build(view.image, depths_of(view), camera_, points);
  if (keyframe->points.level(0).count < image_options_.min_points) return nullptr;
  if (surfaces_ && !view.blocks.empty()) keyframe->planes = surfaces_->planes(view.blocks);
  keyframe->right = {};
  keyframe->depth = {};
  return keyframe;
}

std::optional<RelativePose> ViewAlignment::align(const DirectView& any_keyframe, const DirectView& any_view,
                                                 const SE3& camera_from_keyframe_guess) const {
  const auto& keyframe = static_cast<const AlignedView&>(any_keyframe);
  const auto& view = static_cast<const AlignedView&>(any_view);
  const auto by_image = by_intensities(keyframe, view, camera_from_keyframe_guess);
  const RelativePose loose{camera_from_keyframe_guess, loose_sigma * loose_sigma * Matrix6d::Identity()};
  const auto joint = with_surfaces(keyframe, view, by_image.value_or(loose));
  if (!by_image && !joint) return std::nullopt;
  RelativePose pose = !joint ? *by_image : !by_image ? *joint : judged(*by_image, *joint);
  pose.covariance.diagonal().head<3>().array() += options_.common_sigma_m * options_.common_sigma_m;
  pose.covariance.diagonal().tail<3>().array() += options_.common_sigma_rad * options_.common_sigma_rad;
  if (!pose.covariance.allFinite()) return std::nullopt;
  return pose;
}

std::optional<RelativePose> ViewAlignment::by_intensities(const AlignedView& keyframe, const AlignedView& view,
                                                          const SE3& guess) const {
  const ImageAlignment aligned = align_image(keyframe.points, view.image, guess, image_options_);
  if (!aligned.ok() || aligned.alike_share < options_.trusted_alike) return std::nullopt;
  const Matrix6d to_left = aligned.image_from_reference.adjoint();
  return RelativePose{aligned.image_from_reference, symmetric(to_left * aligned.covariance * to_left.transpose())};
}

/// Gauss-Newton over the surfaces' cost and the normal distribution around `start`; nullopt where they have too little
/// in common.
std::optional<RelativePose> ViewAlignment::with_surfaces(const AlignedView& keyframe, const AlignedView& view,
                                                         const RelativePose& start) const {
  if (keyframe.planes.empty() || view.blocks.empty()) return std::nullopt;
  const Matrix6d information = start.covariance.inverse();
  RelativePose joint = start;
  for (int i = 0; i < surface_iterations; ++i) {
    const SE3 keyframe_from_camera = joint.camera_from_keyframe.inverse();
    const SE3 depth_from_depth = keyframe.depth_from_color * keyframe_from_camera * view.depth_from_color.inverse();
    if (i == 0 && surfaces_->overlap(keyframe.planes, view.blocks, depth_from_depth, overlap_reach_m) < least_overlap)
      return std::nullopt;
    const SurfaceFit fit =
        surfaces_->compare(keyframe.planes, view.blocks, depth_from_depth, surface_reach_m, surface_step);
    if (fit.compared < least_blocks) return std::nullopt;
    // exp(d) * camera_from_keyframe moves the depth camera by the negative of d, in its own axes.
    const Matrix6d by_motion = -view.depth_from_color.adjoint();
    const double weight = options_.surface_weight * surface_step * surface_step;
    const Matrix6d of_surfaces = weight * by_motion.transpose() * fit.information * by_motion;
    const Vector6d off = (joint.camera_from_keyframe * start.camera_from_keyframe.inverse()).log();
    const Matrix6d sum = information + of_surfaces;
    const Vector6d step = sum.ldlt().solve(Vector6d(weight * by_motion.transpose() * fit.gradient - information * off));
    if (!step.allFinite()) return std::nullopt;
    joint.camera_from_keyframe = SE3::exp(step) * joint.camera_from_keyframe;
    joint.covariance = symmetric(sum.inverse());
  }
  return joint;
}

/// Where the surfaces contradict the images, depth and color are not registered, in space or time. Images need the
/// depth less; but what both disagree by is an error that more pixels do not reduce.
RelativePose ViewAlignment::judged(const RelativePose& by_image, const RelativePose& joint) const {
  const Vector6d off = (joint.camera_from_keyframe * by_image.camera_from_keyframe.inverse()).log();
  if (off.dot(by_image.covariance.ldlt().solve(off)) <= 6.0 * options_.most_disagreement) return joint;
  RelativePose result = by_image;
  result.covariance.diagonal().head<3>().array() += options_.disagreement_share / 3.0 * off.head<3>().squaredNorm();
  result.covariance.diagonal().tail<3>().array() += options_.disagreement_share / 3.0 * off.tail<3>().squaredNorm();
  return result;
}

}  // namespace rastro
