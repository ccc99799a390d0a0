// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/initialization/convergence_check.h"

#include <gtest/gtest.h>

#include "rastro/slam/lsd/tracking/alignment_reference.h"
#include "rastro/synthetic/worlds/hall.h"

namespace rastro {
namespace {

/// Frames of the hall, and keyframes with its depths.
class ConvergenceCheckTest : public testing::Test {
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

  /// Frames from `first` on, until the depths were compared or there are no more.
  void follow(const CurrentKeyframe& keyframe, int first) {
    const double before = check_.difference();
    for (int k = first; k < first + 30 && check_.difference() == before; ++k) check_.take(frame(k), keyframe);
  }

  const World world_ = make_hall({.seed = 2, .scale = 0.5});
  TaskPool pool_{2};
  LsdOptions options_;
  ConvergenceCheck check_{{}, world_.camera(), &pool_};
};

TEST_F(ConvergenceCheckTest, TrueDepthsAreConfirmedOnceTwoComparisonsAgree) {
  follow(keyframe(0, 0, 0.0F), 1);
  EXPECT_GT(check_.difference(), 0.0);
  EXPECT_LT(check_.difference(), 0.1);
  EXPECT_FALSE(check_.has_converged()) << "once is chance";
  follow(keyframe(1, 12, 0.0F), 13);
  EXPECT_TRUE(check_.has_converged());
}

TEST_F(ConvergenceCheckTest, DepthsThatAreAllAlikeAreNot) {
  follow(keyframe(0, 0, 1.0F), 1);
  EXPECT_GT(check_.difference(), 0.15);
  follow(keyframe(1, 12, 0.0F), 13);
  EXPECT_LT(check_.difference(), 0.1);
  EXPECT_FALSE(check_.has_converged()) << "not twice in a row";
}

TEST_F(ConvergenceCheckTest, AfterAGapItBeginsAgain) {
  follow(keyframe(0, 0, 0.0F), 1);
  check_.reset();
  follow(keyframe(1, 12, 0.0F), 13);
  EXPECT_FALSE(check_.has_converged());
}

}  // namespace
}  // namespace rastro
