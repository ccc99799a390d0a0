// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/current_keyframe.h"

#include <utility>

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

CurrentKeyframe::CurrentKeyframe(const LsdOptions& options, const Camera& camera, TaskPool* pool, std::int64_t id,
                                 const LsdFrame& frame, const InverseDepthMap* depth)
    : options_(options), camera_(camera), pool_(pool), depth_(frame.image.view(), camera, depth_options(options)) {
  depth ? depth_.start_from(*depth) : depth_.start_random(seed_for(options.seed, static_cast<std::uint64_t>(id)));
  begin(id, frame);
}

void CurrentKeyframe::begin(std::int64_t id, const LsdFrame& frame) {
  id_ = id;
  frame_ = frame.index;
  stamp_ = frame.stamp;
  image_ = frame.image;
  pyramid_ = frame.pyramid;
  frames_ = 0;
  update_reference();
}

void CurrentKeyframe::update_reference() {
  depth_.regularize(pool_);
  AlignmentReferenceOptions options;
  options.levels = options_.levels;
  options.max_points = options_.max_points;
  reference_.build(pyramid_, depth_.inverse_depth(), camera_, options);
  mean_inverse_depth_ = rastro::mean_inverse_depth(depth_.inverse_depth());
}

ImageAlignment CurrentKeyframe::track(const Pyramid& image, const SE3& image_from_keyframe) const {
  ImageAlignmentOptions options;
  options.coarsest_level = options_.levels - 1;
  options.min_overlap = options_.min_overlap;
  return align_image(reference_, image, image_from_keyframe, options, pool_);
}

void CurrentKeyframe::refine(const LsdFrame& frame, const ImageAlignment& tracked) {
  depth_.observe(frame.image.view(), tracked.image_from_reference, tracked.gain, tracked.offset, pool_);
  ++frames_;
  update_reference();
}

Sim3 CurrentKeyframe::change_to(std::int64_t id, const LsdFrame& frame, const SE3& new_from_keyframe) {
  depth_ = depth_.propagate(frame.image.view(), new_from_keyframe);
  const double mean = rastro::mean_inverse_depth(depth_.inverse_depth());
  const double unit = mean > 0.0 ? 1.0 / mean : 1.0;
  depth_.rescale(unit);
  begin(id, frame);
  return Sim3(new_from_keyframe.inverse()) * Sim3(unit, SO3(), Eigen::Vector3d::Zero());
}

std::shared_ptr<const SemiDenseKeyframe> CurrentKeyframe::published() const {
  return std::make_shared<const SemiDenseKeyframe>(
      SemiDenseKeyframe{id_, frame_, stamp_, image_, depth_.inverse_depth(), mean_inverse_depth_});
}

}  // namespace rastro
