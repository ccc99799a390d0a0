// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/initialization/convergence_check.h"

#include <gtest/gtest.h>

#include "rastro/slam/lsd/tracking/alignment_reference.h"
#include "rastro/synthetic/worlds/hall.h"

namespace rastro {
namespace {

/// Frames of the hall, and keyframes with its depths.
class ConvergenceCheckTest : public ::testing::Test {
 protected:
  LsdFrame frame(int index) {
    LsdFrame made;
    made.index = index;
    made.stamp = index * TimeNs{50'000'000};
    made.image = world_.render(index, pool_).gray;
    return made;
  }

  /// Exact where `flatness` is 0, in a unit of its own; all alike where it is 1.
  CurrentKeyframe keyframe(std::int64_t id, int index, float flatness) {
    const RenderedFrame rendered = world_.render(index, pool_);
    const auto pyramid = std::make_shared<const Pyramid>(alignment_pyramid(rendered.gray.view(), 3));
    InverseDepthMap depth(rendered.gray.width(), rendered.gray.height());
    for (int y = 0; y < depth.height(); ++y)
      for (int x = 0; x < depth.width(); ++x) {
        const float meters = rendered.depth.at(x, y);
        if (!(meters > 0.0F)) continue;
        depth.mean.at(x, y) = flatness * 1.0F + (1.0F - flatness) * 3.0F / meters;
        depth.variance.at(x, y) = 1e-4F;
      }
    auto reference = std::make_shared<AlignmentReference>();
    reference->build(*pyramid, depth, world_.camera(), {.levels = 3});
    return {options_, nullptr, id, pyramid, reference, 1.0, 5};
  }

  /// Frames from `first` on, until the depths were compared or there are no more. True: they have converged.
  bool follow(const CurrentKeyframe& keyframe, int first) {
    const double before = check_.difference();
    bool was_compared = false;
    for (int k = first; k < first + 30 && !was_compared; ++k) {
      if (check_.take(frame(k), keyframe)) return true;
      was_compared = check_.difference() != before;
    }
    return false;
  }

  const World world_ = make_hall({.seed = 2, .scale = 0.5});
  TaskPool pool_{2};
  LsdOptions options_;
  ConvergenceCheck check_{{}, world_.camera(), &pool_};
};

TEST_F(ConvergenceCheckTest, TrueDepthsAreConfirmedOnceTwoKeyframesAgree) {
  check_.begin(3);
  EXPECT_FALSE(follow(keyframe(3, 0, 0.0F), 1)) << "once is chance";
  EXPECT_GT(check_.difference(), 0.0);
  EXPECT_LT(check_.difference(), 0.1);
  EXPECT_TRUE(check_.is_doubtful(3));
  EXPECT_TRUE(follow(keyframe(4, 12, 0.0F), 13));
  for (const std::int64_t id : {2, 3, 4, 5}) EXPECT_FALSE(check_.is_doubtful(id)) << id;
}

TEST_F(ConvergenceCheckTest, TheSameKeyframeTwiceIsOne) {
  check_.begin(0);
  EXPECT_FALSE(follow(keyframe(0, 0, 0.0F), 1));
  EXPECT_FALSE(follow(keyframe(0, 0, 0.0F), 13));
  EXPECT_TRUE(check_.is_doubtful(0));
}

TEST_F(ConvergenceCheckTest, DepthsThatAreAllAlikeAreNot) {
  check_.begin(0);
  follow(keyframe(0, 0, 1.0F), 1);
  EXPECT_GT(check_.difference(), 0.15);
  EXPECT_FALSE(follow(keyframe(1, 12, 0.0F), 13)) << "not twice in a row";
  EXPECT_LT(check_.difference(), 0.1);
  EXPECT_TRUE(follow(keyframe(2, 12, 0.0F), 13));
  EXPECT_TRUE(check_.is_doubtful(0)) << "its own depths stay as they were";
  EXPECT_FALSE(check_.is_doubtful(1));
}

TEST_F(ConvergenceCheckTest, AfterAGapItBeginsAgain) {
  check_.begin(0);
  follow(keyframe(0, 0, 0.0F), 1);
  check_.interrupt();
  EXPECT_FALSE(follow(keyframe(1, 12, 0.0F), 13));
}

TEST_F(ConvergenceCheckTest, OnlyWhatBeganAtRandomIsDoubtful) {
  EXPECT_FALSE(follow(keyframe(0, 0, 0.0F), 1));
  EXPECT_EQ(check_.difference(), 0.0) << "nothing to check";
  check_.begin(5);
  check_.take(frame(1), keyframe(6, 0, 0.0F));
  check_.take(frame(2), keyframe(2, 0, 0.0F));  // found again in an earlier part of the map
  EXPECT_TRUE(check_.is_doubtful(6)) << "still";
  EXPECT_FALSE(check_.is_doubtful(2));
  check_.take(frame(3), keyframe(7, 0, 0.0F));
  EXPECT_FALSE(check_.is_doubtful(7)) << "it follows from the earlier part";
}

}  // namespace
}  // namespace rastro
