// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/slam/lsd/current_keyframe.h"
#include "rastro/slam/lsd/depth/depth_map.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/lsd_sensor.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/lsd/tracking/alignment_pixels.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"

namespace rastro {

/// Tracking's loops never wait for mapping's. Both may be null.
struct LsdPools {
  TaskPool* tracking = nullptr;
  TaskPool* mapping = nullptr;
};

/// The depths of the newest keyframe, which frames improve.
class KeyframeDepths {
 public:
  /// The depths given; else those that the sensor measures, or random ones of one camera. `options`, `sensor` and the
  /// pools outlive this.
  KeyframeDepths(const LsdOptions& options, const LsdSensor& sensor, const LsdPools& pools, std::int64_t id,
                 const LsdFrame& frame, const InverseDepthMap* depth);

  /// Small-baseline stereo with a frame that was tracked.
  void refine(const LsdFrame& frame, const ImageAlignment& tracked);
  /// The frame becomes the keyframe, with the depths of this one propagated. Returns keyframe_from_new: its scale is
  /// the new unit in that of the keyframe before; 1 where depth is metric. `depth_from_color`: motion of the camera
  /// from the instant of the image to that of a depth camera's depth.
  Sim3 change_to(std::int64_t id, const LsdFrame& frame, const ImageAlignment& tracked, const SE3& depth_from_color);

  std::int64_t id() const { return id_; }
  double mean_inverse_depth() const { return mean_inverse_depth_; }
  int pixels() const { return reference_->level(0).count; }  ///< With a depth.
  /// As the depths are now.
  CurrentKeyframe current() const {
    return {options_, pools_.tracking, id_, pyramid_, reference_, mean_inverse_depth_, frames_};
  }
  std::shared_ptr<const SemiDenseKeyframe> published() const;

 private:
  /// An earlier image with its pose, and its intensities relative to those of the keyframe.
  struct View {
    GrayImage image, mask;
    SE3 camera_from_keyframe;
    double gain = 1.0, offset = 0.0;
  };
  void remember(View view);
  void observe_earlier(const ImageAlignment& tracked, double unit);
  void begin(std::int64_t id, const LsdFrame& frame, const SE3& depth_from_color);
  void measure(const LsdFrame& frame, const SE3& depth_from_color);
  template <typename Sensor>
  void measure_by(const Sensor& sensor);
  void update_reference();

  const LsdOptions& options_;
  const LsdSensor& sensor_;
  LsdPools pools_;
  std::int64_t id_ = 0;
  std::int64_t frame_ = 0;
  TimeNs stamp_ = 0;
  GrayImage image_, mask_;
  std::shared_ptr<const Pyramid> pyramid_;
  DepthMap depth_;
  std::vector<AlignmentPixels> pixels_;        ///< Of each level.
  std::vector<InverseDepthMap> coarse_depth_;  ///< Of the levels after the finest.
  std::shared_ptr<const AlignmentReference> reference_;
  double mean_inverse_depth_ = 1.0;
  std::vector<SensedDepth> sensed_;
  int frames_ = 0;            ///< That refined it.
  std::vector<View> recent_;  ///< The last ones, in order.
};

}  // namespace rastro
