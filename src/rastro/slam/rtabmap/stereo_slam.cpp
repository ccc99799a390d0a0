// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/stereo_slam.h"

#include <utility>

#include "rastro/base/stopwatch.h"

namespace rastro {

StereoSlam::StereoSlam(const StereoPair& pair, const StereoRange& range, TaskPool* pool, std::unique_ptr<Slam> slam)
    : depth_({pair.camera.fx * pair.baseline, range.least, range.most}), slam_(std::move(slam)) {
  if (pair.rectification) rectifier_.emplace(pair.rectification, pool);
}

SlamUpdate StereoSlam::process(const Frame& frame) {
  Stopwatch stage;
  const Frame seen = with_depth(frame);
  const double milliseconds = stage.lap_ms();
  SlamUpdate update = slam_->process(seen);
  update.times.insert(update.times.begin(), {"stereo", milliseconds});
  update.milliseconds += milliseconds;
  return update;
}

Frame StereoSlam::with_depth(const Frame& recorded) const {
  Frame frame = rectifier_ && !recorded.image.empty() ? rectifier_->rectified(recorded) : recorded;
  if (!frame.image.empty() && !frame.right.empty()) frame.depth = depth_.depth(frame.image.view(), frame.right.view());
  frame.depth_stamp = frame.stamp;
  frame.right = {};
  return frame;
}

}  // namespace rastro
