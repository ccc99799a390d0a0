// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/keyframe_depths.h"

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

KeyframeDepths::KeyframeDepths(const LsdOptions& options, const LsdSensor& sensor, const LsdPools& pools,
                               std::int64_t id, const LsdFrame& frame, const InverseDepthMap* depth)
    : options_(options),
      sensor_(sensor),
      pools_(pools),
      depth_(frame.image.view(), sensor.camera, depth_options(options), frame.mask.view()) {
  if (depth)
    depth_.start_from(*depth);
  else if (!sensor.is_metric())
    depth_.start_random(seed_for(options.seed, static_cast<std::uint64_t>(id)));
  begin(id, frame, SE3());
}

void KeyframeDepths::begin(std::int64_t id, const LsdFrame& frame, const SE3& depth_from_color) {
  id_ = id;
  frame_ = frame.index;
  stamp_ = frame.stamp;
  image_ = frame.image;
  mask_ = frame.mask;
  // Depths end at the mask, but on coarse levels black would reach into what they are compared with.
  pyramid_ = std::make_shared<const Pyramid>(
      mask_.empty() ? frame.pyramid : alignment_pyramid(image_.view(), options_.levels, pools_.mapping));
  const int levels = std::min(options_.levels, pyramid_->levels());
  pixels_ = alignment_pixels(*pyramid_, levels, AlignmentReferenceOptions().min_gradient);
  coarse_depth_.resize(pixels_.size() - 1);
  frames_ = 0;
  measure(frame, depth_from_color);
  update_reference();
}

void KeyframeDepths::measure(const LsdFrame& frame, const SE3& depth_from_color) {
  sensed_.clear();
  if (!frame.right.empty())
    measure_by(StereoMeasurement(frame, sensor_, options_, depth_options(options_).search, pools_.mapping));
  if (!frame.depth.empty()) measure_by(DepthCameraMeasurement(frame.depth, depth_from_color, sensor_, options_));
}

template <typename Sensor>
void KeyframeDepths::measure_by(const Sensor& sensor) {
  SensedDepthMap sensed(image_.width(), image_.height());
  const auto find = [&](const EpipolarQueries& queries, EpipolarMatches& matches) {
    sensor.find(queries, matches);
    sensed.note(queries, matches);
  };
  depth_.measure(find, pools_.mapping);
  // Half a cell of the refinement: the pixel that this chooses is one of them, if it was measured.
  sensed_ = sensed.thinned(image_.view(), cell_for(options_.refine_points, image_.width(), image_.height()) / 2);
}

void KeyframeDepths::update_reference() {
  depth_.regularize(pools_.mapping);
  const InverseDepthMap* finer = &depth_.inverse_depth();
  for (InverseDepthMap& coarse : coarse_depth_) {
    halve(*finer, coarse);
    finer = &coarse;
  }
  auto reference = std::make_shared<AlignmentReference>();
  reference->set_points(*pyramid_, pixels_, depth_.inverse_depth(), coarse_depth_, sensor_.camera, options_.max_points);
  reference_ = std::move(reference);
  mean_inverse_depth_ = rastro::mean_inverse_depth(depth_.inverse_depth());
}

void KeyframeDepths::refine(const LsdFrame& frame, const ImageAlignment& tracked) {
  depth_.observe(frame.image.view(), tracked.image_from_reference, tracked.gain, tracked.offset, pools_.mapping,
                 frame.mask.view());
  ++frames_;
  remember({frame.image, frame.mask, tracked.image_from_reference, tracked.gain, tracked.offset});
  update_reference();
}

void KeyframeDepths::remember(View view) {
  recent_.push_back(std::move(view));
  if (recent_.size() > static_cast<std::size_t>(options_.earlier_frames)) recent_.erase(recent_.begin());
}

/// What came into view since the last keyframe was seen by the frames right before.
void KeyframeDepths::observe_earlier(const ImageAlignment& tracked, double unit) {
  const SE3 keyframe_from_new = tracked.image_from_reference.inverse();
  std::vector<View> earlier;
  earlier.swap(recent_);
  for (View& view : earlier) {
    const SE3 view_from_new = view.camera_from_keyframe * keyframe_from_new;
    const SE3 in_new_unit(view_from_new.rotation(), view_from_new.translation() / unit);
    const double gain = view.gain / tracked.gain;
    const double offset = view.offset - gain * tracked.offset;
    depth_.observe(view.image.view(), in_new_unit, gain, offset, pools_.mapping, view.mask.view());
    remember({std::move(view.image), std::move(view.mask), in_new_unit, gain, offset});
  }
}

Sim3 KeyframeDepths::change_to(std::int64_t id, const LsdFrame& frame, const ImageAlignment& tracked,
                               const SE3& depth_from_color) {
  const SE3& new_from_keyframe = tracked.image_from_reference;
  depth_ = depth_.propagate(frame.image.view(), new_from_keyframe, tracked.gain, tracked.offset, frame.mask.view());
  const double mean = depth_.mean();
  const double unit = mean > 0.0 && !sensor_.is_metric() ? 1.0 / mean : 1.0;
  depth_.rescale(unit);
  if (mean > 0.0) depth_.expect(unit * mean);
  observe_earlier(tracked, unit);
  remember({frame.image, frame.mask, SE3(), 1.0, 0.0});
  begin(id, frame, depth_from_color);
  return Sim3(new_from_keyframe.inverse()) * Sim3(unit, SO3(), Eigen::Vector3d::Zero());
}

std::shared_ptr<const SemiDenseKeyframe> KeyframeDepths::published() const {
  return std::make_shared<const SemiDenseKeyframe>(
      SemiDenseKeyframe{id_, frame_, stamp_, image_, depth_.inverse_depth(), mean_inverse_depth_, mask_, sensed_});
}

}  // namespace rastro
