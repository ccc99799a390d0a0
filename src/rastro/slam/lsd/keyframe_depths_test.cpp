// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/keyframe_depths.h"

#include <gtest/gtest.h>

#include <vector>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

/// A room in which a depth camera sees the left half alone.
class HalfSeenRoom {
 public:
  HalfSeenRoom() : first_(room_.render({})) {
    for (const double x : moved_m) views_.push_back(room_.render({SO3(), {x, 0.0, 0.0}}).gray);
  }

  /// Pixels of the right half that frames of other places give a depth, where all is `unit` times as large.
  int depths_from_motion(double unit) const {
    LsdSensor sensor = single_camera(room_.camera());
    sensor.kind = CameraKind::depth;
    const LsdFrameMaker frames(sensor, options_.levels, nullptr);
    LsdFrame frame = frames.from_image(0, 0, first_.gray);
    frame.depth = DepthImage(frame.image.width(), frame.image.height());
    const int middle = frame.image.width() / 2;
    for (int y = 0; y < frame.image.height(); ++y)
      for (int x = 0; x < middle; ++x) frame.depth.at(x, y) = static_cast<float>(unit) * first_.depth.at(x, y);
    KeyframeDepths depths(options_, sensor, {}, 0, frame, nullptr);
    for (std::size_t k = 0; k < views_.size(); ++k) {
      ImageAlignment tracked;
      tracked.image_from_reference = SE3(SO3(), {-unit * moved_m[k], 0.0, 0.0});
      const auto index = static_cast<std::int64_t>(k) + 1;
      depths.refine(frames.from_image(index, index, views_[k]), tracked);
    }
    const auto known = depths.published();
    int count = 0;
    for (int y = 0; y < known->depth.height(); ++y)
      for (int x = middle; x < known->depth.width(); ++x) count += known->depth.is_known(x, y) ? 1 : 0;
    return count;
  }

 private:
  static constexpr double moved_m[] = {0.25, 0.275, 0.3};
  LsdOptions options_;
  testing::AlignmentRoom room_;
  RenderedFrame first_;
  std::vector<GrayImage> views_;
};

/// Not in meters either: they are searched for near the mean of those that are known.
TEST(KeyframeDepths, DepthsFromMotionDoNotDependOnTheUnit) {
  const HalfSeenRoom room;
  constexpr double about_one = 0.3;  // the mean inverse depth is then
  const int expected = room.depths_from_motion(about_one);
  EXPECT_GT(expected, 500);
  EXPECT_GT(room.depths_from_motion(1.0), 0.7 * expected);
}

}  // namespace
}  // namespace rastro
