// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/slam/lsd/depth/depth_map.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/lsd_sensor.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"

namespace rastro {

/// The newest keyframe: frames are tracked on its depths, and improve them.
class CurrentKeyframe {
 public:
  /// The depths given; else those that the sensor measures, or random ones of one camera. `options` and `sensor`
  /// outlive this.
  CurrentKeyframe(const LsdOptions& options, const LsdSensor& sensor, TaskPool* pool, std::int64_t id,
                  const LsdFrame& frame, const InverseDepthMap* depth);

  ImageAlignment track(const Pyramid& image, const SE3& image_from_keyframe) const;
  /// Small-baseline stereo with a frame that was tracked.
  void refine(const LsdFrame& frame, const ImageAlignment& tracked);
  /// The frame becomes the keyframe, with the depths of this one propagated. Returns keyframe_from_new: its scale is
  /// the new unit in that of the keyframe before; 1 where depth is metric. `depth_from_color`: motion of the camera
  /// from the instant of the image to that of a depth camera's depth.
  Sim3 change_to(std::int64_t id, const LsdFrame& frame, const ImageAlignment& tracked, const SE3& depth_from_color);

  std::int64_t id() const { return id_; }
  const Pyramid& pyramid() const { return pyramid_; }
  double mean_inverse_depth() const { return mean_inverse_depth_; }
  int frames() const { return frames_; }  ///< That refined it.
  int pixels() const;                     ///< With a depth.
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
  void update_reference();

  const LsdOptions& options_;
  const LsdSensor& sensor_;
  TaskPool* pool_;
  std::int64_t id_ = 0;
  std::int64_t frame_ = 0;
  TimeNs stamp_ = 0;
  GrayImage image_, mask_;
  Pyramid pyramid_;
  DepthMap depth_;
  AlignmentReference reference_;
  double mean_inverse_depth_ = 1.0;
  int frames_ = 0;
  std::vector<View> recent_;  ///< The last ones, in order.
};

}  // namespace rastro
