// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/current_keyframe.h"

#include <utility>

#include "rastro/slam/lsd/depth_measurement.h"
#include "rastro/slam/lsd/initialization/two_view_start.h"

namespace rastro {
namespace {

DepthMapOptions depth_options(const LsdOptions& options) {
  DepthMapOptions depth;
  depth.min_gradient = static_cast<float>(options.min_gradient);
  depth.growth = options.variance_growth;
  depth.common_share = options.common_share;
  depth.search.intensity_sigma = options.intensity_sigma;
  depth.search.geometry_sigma_px = options.line_sigma_px;
  depth.search.disparity_sigma_px = options.disparity_sigma_px;
  depth.search.min_line_px = options.min_line_px;
  return depth;
}

}  // namespace

CurrentKeyframe::CurrentKeyframe(const LsdOptions& options, const LsdSensor& sensor, TaskPool* pool, std::int64_t id,
                                 const LsdFrame& frame, const InverseDepthMap* depth)
    : options_(options),
      sensor_(sensor),
      pool_(pool),
      depth_(frame.image.view(), sensor.camera, depth_options(options), frame.mask.view()) {
  if (depth)
    depth_.start_from(*depth);
  else if (!sensor.is_metric())
    depth_.start_random(seed_for(options.seed, static_cast<std::uint64_t>(id)));
  begin(id, frame, SE3());
}

void CurrentKeyframe::begin(std::int64_t id, const LsdFrame& frame, const SE3& depth_from_color) {
  id_ = id;
  frame_ = frame.index;
  stamp_ = frame.stamp;
  image_ = frame.image;
  mask_ = frame.mask;
  // Depths end at the mask, but on coarse levels black would reach into what they are compared with.
  pyramid_ = mask_.empty() ? frame.pyramid : alignment_pyramid(image_.view(), options_.levels, pool_);
  const int levels = std::min(options_.levels, pyramid_.levels());
  pixels_ = alignment_pixels(pyramid_, levels, AlignmentReferenceOptions().min_gradient);
  coarse_depth_.resize(pixels_.size() - 1);
  frames_ = 0;
  measure(frame, depth_from_color);
  update_reference();
}

void CurrentKeyframe::measure(const LsdFrame& frame, const SE3& depth_from_color) {
  if (!frame.right.empty()) {
    const StereoMeasurement pair(frame, sensor_, options_, depth_options(options_).search, pool_);
    depth_.measure([&](const auto& queries, auto& matches) { pair.find(queries, matches); }, pool_);
  }
  if (!frame.depth.empty()) {
    const DepthCameraMeasurement camera(frame.depth, depth_from_color, sensor_, options_);
    depth_.measure([&](const auto& queries, auto& matches) { camera.find(queries, matches); }, pool_);
  }
}

void CurrentKeyframe::update_reference() {
  depth_.regularize(pool_);
  const InverseDepthMap* finer = &depth_.inverse_depth();
  for (InverseDepthMap& coarse : coarse_depth_) {
    halve(*finer, coarse);
    finer = &coarse;
  }
  reference_.set_points(pyramid_, pixels_, depth_.inverse_depth(), coarse_depth_, sensor_.camera, options_.max_points);
  mean_inverse_depth_ = rastro::mean_inverse_depth(depth_.inverse_depth());
}

ImageAlignment CurrentKeyframe::track(const Pyramid& image, const SE3& image_from_keyframe) const {
  ImageAlignmentOptions options;
  options.coarsest_level = options_.levels - 1;
  options.min_overlap = options_.min_overlap;
  return align_image(reference_, image, image_from_keyframe, options, pool_);
}

void CurrentKeyframe::refine(const LsdFrame& frame, const ImageAlignment& tracked) {
  depth_.observe(frame.image.view(), tracked.image_from_reference, tracked.gain, tracked.offset, pool_,
                 frame.mask.view());
  ++frames_;
  update_reference();
}

Sim3 CurrentKeyframe::change_to(std::int64_t id, const LsdFrame& frame, const SE3& new_from_keyframe,
                                const SE3& depth_from_color) {
  depth_ = depth_.propagate(frame.image.view(), new_from_keyframe, frame.mask.view());
  const double mean = depth_.mean();
  const double unit = mean > 0.0 && !sensor_.is_metric() ? 1.0 / mean : 1.0;
  depth_.rescale(unit);
  if (mean > 0.0) depth_.expect(unit * mean);
  begin(id, frame, depth_from_color);
  return Sim3(new_from_keyframe.inverse()) * Sim3(unit, SO3(), Eigen::Vector3d::Zero());
}

int CurrentKeyframe::pixels() const { return reference_.level(0).count; }

std::shared_ptr<const SemiDenseKeyframe> CurrentKeyframe::published() const {
  return std::make_shared<const SemiDenseKeyframe>(
      SemiDenseKeyframe{id_, frame_, stamp_, image_, depth_.inverse_depth(), mean_inverse_depth_, mask_});
}

}  // namespace rastro
