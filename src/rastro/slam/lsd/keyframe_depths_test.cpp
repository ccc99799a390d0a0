// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/keyframe_depths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/synthetic/worlds/hall.h"

namespace rastro {
namespace {

const World& hall() {
  static const World world = make_hall({.seed = 1, .scale = 0.5});
  return world;
}

LsdSensor depth_camera() {
  LsdSensor sensor = single_camera(hall().camera());
  sensor.kind = CameraKind::depth;
  return sensor;
}

/// Median of the relative errors of a keyframe's depths.
double median_error(const KeyframeDepths& depths, const DepthImage& truth) {
  const auto keyframe = depths.published();
  std::vector<double> errors;
  for (int y = 0; y < truth.height(); ++y)
    for (int x = 0; x < truth.width(); ++x)
      if (keyframe->depth.is_known(x, y) && truth.at(x, y) > 0.0F)
        errors.push_back(
            std::abs(static_cast<double>(keyframe->depth.mean.at(x, y)) * static_cast<double>(truth.at(x, y)) - 1.0));
  if (errors.empty()) return 1.0;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  return errors[errors.size() / 2];
}

/// The camera flies ahead, and its depth images are three frames late.
TEST(KeyframeDepths, OfTheFirstKeyframeAreMovedToItsImageOnceTheMotionIsKnown) {
  TaskPool pool(1);
  LsdOptions options;
  // So that later frames hardly change what was measured; surfaces may slant as much as by default.
  options.depth_sigma_per_m2 = 0.0005, options.depth_edge_sigmas = 16.0;
  const LsdSensor sensor = depth_camera();
  const LsdFrameMaker frames(sensor, options.levels, nullptr);
  const RenderedFrame color = hall().render(120, pool), late = hall().render(123, pool);
  LsdFrame first = frames.from_image(0, 0, color.gray);
  first.depth = late.depth, first.depth_stamp = 3;
  const LsdFrame second = frames.from_image(1, 6, hall().render(126, pool).gray);
  ImageAlignment tracked;
  tracked.image_from_reference = hall().world_from_camera(126).inverse() * hall().world_from_camera(120);

  KeyframeDepths depths(options, sensor, {}, 0, first, nullptr);
  const double before = median_error(depths, color.depth);
  KeyframeDepths changed(options, sensor, {}, 0, first, nullptr);
  depths.refine(second, tracked);
  EXPECT_LT(median_error(depths, color.depth), 0.5 * before);

  changed.change_to(1, second, tracked, SE3());
  EXPECT_LT(median_error(changed, hall().render(126, pool).depth), 0.5 * before) << "already the next keyframe";
}

TEST(KeyframeDepths, OfTheFirstKeyframeStayWhereTheDepthIsOfTheSameInstant) {
  TaskPool pool(1);
  const LsdOptions options;
  const LsdSensor sensor = depth_camera();
  const LsdFrameMaker frames(sensor, options.levels, nullptr);
  const RenderedFrame color = hall().render(120, pool);
  LsdFrame first = frames.from_image(0, 0, color.gray);
  first.depth = color.depth;
  KeyframeDepths depths(options, sensor, {}, 0, first, nullptr);
  EXPECT_LT(median_error(depths, color.depth), 0.01);
  ImageAlignment standstill;
  depths.refine(frames.from_image(1, 6, color.gray), standstill);
  EXPECT_LT(median_error(depths, color.depth), 0.01);
}

}  // namespace
}  // namespace rastro
