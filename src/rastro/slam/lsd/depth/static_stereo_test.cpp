// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/static_stereo.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

constexpr double baseline = 0.12;

struct RenderedPair {
  testing::AlignmentRoom room;
  RenderedFrame left = room.render(SE3());
  GrayImage right = room.render(SE3(SO3(), {baseline, 0.0, 0.0})).gray;
};
RenderedPair& rendered_pair() {
  static RenderedPair pair;
  return pair;
}

struct StereoErrors {
  int matched = 0, within_5_percent = 0, within_2_sigma = 0;
};

/// Without any prior.
StereoErrors errors_of_stereo(const GrayImage& right, double gain, double offset, double max_disparity_px) {
  const RenderedPair& pair = rendered_pair();
  const Pyramid left_pyramid = alignment_pyramid(pair.left.gray, 5), right_pyramid = alignment_pyramid(right, 5);
  StaticStereoOptions options;
  options.baseline = baseline;
  options.max_disparity_px = max_disparity_px;
  options.search.disparity_sigma_px = 0.3;
  const StaticStereo stereo(left_pyramid, right_pyramid, pair.room.camera(), gain, offset, options);
  StereoErrors errors;
  for (int y = 6; y < pair.left.gray.height() - 6; y += 2)
    for (int x = 6; x < pair.left.gray.width() - 6; x += 2) {
      const EpipolarMatch match = stereo.find(x, y, {0.0, 1.0, 10.0});
      if (match.result != EpipolarResult::matched || !(pair.left.depth.at(x, y) > 0.0F)) continue;
      const double exact = 1.0 / static_cast<double>(pair.left.depth.at(x, y)),
                   error = std::abs(static_cast<double>(match.mean) - exact);
      ++errors.matched;
      errors.within_5_percent += error < 0.05 * exact;
      errors.within_2_sigma += error < 2.0 * std::sqrt(static_cast<double>(match.variance));
    }
  return errors;
}

TEST(StaticStereo, MeasuresDepthsInMetersFromASinglePair) {
  const StereoErrors errors = errors_of_stereo(rendered_pair().right, 1.0, 0.0, 100.0);
  EXPECT_GT(errors.matched, 1500);
  EXPECT_GT(errors.within_5_percent, 0.85 * errors.matched);
  EXPECT_GT(errors.within_2_sigma, 0.85 * errors.matched);
}

TEST(StaticStereo, AnotherBrightnessOfTheRightCameraMakesNoDifference) {
  const GrayImage brighter = testing::exposed(rendered_pair().right, 1.2, -10.0, 0.0, 1);
  const StereoErrors errors = errors_of_stereo(brighter, 1.2, -10.0, 100.0);
  EXPECT_GT(errors.matched, 1500);
  EXPECT_GT(errors.within_5_percent, 0.85 * errors.matched);
}

/// Both directions must agree, so that no wrong depth takes the place of one that is not searched.
TEST(StaticStereo, WhatIsNearerThanTheLargestDisparityHasHardlyAnyDepth) {
  const StereoErrors all = errors_of_stereo(rendered_pair().right, 1.0, 0.0, 100.0),
                     far = errors_of_stereo(rendered_pair().right, 1.0, 0.0, 8.0);
  EXPECT_GT(far.matched, 100);
  EXPECT_LT(far.matched, 0.8 * all.matched);
  EXPECT_GT(far.within_5_percent, 0.75 * far.matched);
}

TEST(StaticStereo, APriorNarrowsTheSearch) {
  const RenderedPair& pair = rendered_pair();
  const Pyramid left = alignment_pyramid(pair.left.gray, 5), right = alignment_pyramid(pair.right, 5);
  const StaticStereo stereo(left, right, pair.room.camera(), 1.0, 0.0, {.baseline = baseline});
  int matched = 0, outside = 0;
  for (int y = 20; y < 220; y += 5)
    for (int x = 60; x < 300; x += 5) {
      if (!(pair.left.depth.at(x, y) > 0.0F)) continue;
      const double exact = 1.0 / static_cast<double>(pair.left.depth.at(x, y));
      const EpipolarMatch match = stereo.find(x, y, {0.97 * exact, exact, 1.03 * exact, true});
      if (match.result != EpipolarResult::matched) continue;
      ++matched;
      // Two places are added on each side.
      outside += std::abs(static_cast<double>(match.mean) - exact) * pair.room.camera().fx * baseline > 3.5;
    }
  EXPECT_GT(matched, 200);
  EXPECT_EQ(outside, 0);
}

}  // namespace
}  // namespace rastro
