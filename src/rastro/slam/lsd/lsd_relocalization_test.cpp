// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_relocalization.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

/// A room with one keyframe at the origin.
class LsdRelocalizationTest : public ::testing::Test {
 protected:
  static constexpr double mean_inverse_depth = 0.3;

  CurrentKeyframe keyframe() const {
    auto pyramid = std::make_shared<const Pyramid>(alignment_pyramid(first_.gray, options_.levels));
    auto reference = std::make_shared<AlignmentReference>();
    reference->build(*pyramid, depth_, room_.camera(), {options_.levels, 5.0, 0});
    return {options_, nullptr, 0, pyramid, reference, mean_inverse_depth, 10};
  }
  void add_keyframe(std::int64_t id, const SE3& world_from_keyframe) {
    graph_.add(std::make_shared<const SemiDenseKeyframe>(
                   SemiDenseKeyframe{id, id, id, first_.gray, depth_, mean_inverse_depth}),
               Sim3(world_from_keyframe), 0);
  }
  /// A frame there, after so many without a pose.
  std::optional<LsdRelocalization::Confirmed> look_for(const SE3& world_from_camera, int missed, bool was_tried) {
    const LsdFrame frame =
        LsdFrameMaker(sensor_, options_.levels, nullptr).from_image(1000, 1000, room_.render(world_from_camera).gray);
    PoseSearch search(options_, room_.camera());
    search.remember(alignment_pyramid(first_.gray, options_.levels));
    LsdRelocalization relocalization(options_, graph_, [&](std::int64_t) { return keyframe(); });
    update_ = {};
    return relocalization.take(
        frame, keyframe(), {SE3(), SE3(), missed}, search, was_tried, [&] { return words_; }, update_);
  }

  testing::AlignmentRoom room_;
  LsdOptions options_;
  LsdSensor sensor_ = single_camera(room_.camera());
  RenderedFrame first_ = room_.render({});
  InverseDepthMap depth_ = testing::semi_dense_depth(first_, 5.0, 0.01, 1);
  SemiDenseGraph graph_{options_, true};
  BagOfWords words_;
  SlamUpdate update_;
};

/// Two of 3.3 meters, which is the mean distance of what it shows, and not one meter.
TEST_F(LsdRelocalizationTest, WhatIsFoundAsFarAwayAsTheViewReachesIsBelieved) {
  words_.words = {{1, 0.5F}, {2, 0.5F}};
  for (const double away_m : {2.0, 5.0}) {
    graph_ = SemiDenseGraph(options_, true);
    add_keyframe(0, SE3());
    add_keyframe(1, SE3(SO3(), {away_m, 0.0, 0.0}));
    graph_.add_words(0, words_);
    graph_.add_frame({0, 0, 0, SE3()});
    for (std::int64_t k = 1; k < 500; ++k) graph_.add_frame({k, k, 1, SE3()});
    EXPECT_FALSE(look_for({SO3(), {0.02, 0.0, 0.0}}, 0, true));
    EXPECT_EQ(update_.reason, away_m < 3.0 ? SlamReason::unconfirmed : SlamReason::not_found) << away_m;
  }
}

TEST_F(LsdRelocalizationTest, OneFrameIsEnoughNextToTheLastPoseRightAfterTheLoss) {
  const SE3 nearby(SO3::exp({0.0, 0.01, 0.0}), {0.02, 0.0, 0.0});
  EXPECT_TRUE(look_for(nearby, 1, false)) << update_.detail;
  EXPECT_FALSE(look_for(nearby, 10, false));
  EXPECT_EQ(update_.reason, SlamReason::unconfirmed);
}

}  // namespace
}  // namespace rastro
