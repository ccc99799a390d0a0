// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/image_alignment.h"

#include <gtest/gtest.h>

#include "rastro/base/simd_testing.h"
#include "rastro/image/image_testing.h"
#include "rastro/math/math_testing.h"
#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

using testing::AlignmentRoom;
using testing::exposed;
using testing::pose_near;
using testing::semi_dense_depth;

AlignmentRoom& alignment_room() {
  static AlignmentRoom room;
  return room;
}
const RenderedFrame& reference_frame() {
  static const RenderedFrame frame = alignment_room().render(SE3());
  return frame;
}

AlignmentReference reference_of(const GrayImage& image, const InverseDepthMap& depth) {
  AlignmentReference reference;
  reference.build(alignment_pyramid(image, 5), depth, alignment_room().camera());
  return reference;
}
const AlignmentReference& exact_reference() {
  static const AlignmentReference reference =
      reference_of(reference_frame().gray, semi_dense_depth(reference_frame(), 5.0, 0.0, 1));
  return reference;
}

SE3 motion_of(const Vector6d& tangent) { return SE3::exp(tangent); }
/// About 20 px between the images at 320 x 240, half of it rotation.
SE3 large_motion() { return motion_of((Vector6d() << 0.1, -0.03, 0.08, 0.01, -0.04, 0.03).finished()); }
SE3 small_motion() { return motion_of((Vector6d() << 0.01, 0.008, -0.02, 0.003, 0.004, -0.006).finished()); }

GrayImage image_at(const SE3& image_from_reference) {
  return alignment_room().render(image_from_reference.inverse()).gray;
}

ImageAlignment align_from_rest(const AlignmentReference& reference, const GrayImage& image) {
  return align_image(reference, alignment_pyramid(image, 5), SE3());
}

TEST(ImageAlignment, RecoversTheMotionBetweenRenderedViews) {
  for (const SE3& truth : {SE3(), small_motion(), large_motion()}) {
    const ImageAlignment result = align_from_rest(exact_reference(), image_at(truth));
    EXPECT_TRUE(result.ok()) << to_string(result.failure);
    EXPECT_TRUE(result.converged);
    EXPECT_THAT(result.image_from_reference, pose_near(truth, 0.001, 0.0003));
    EXPECT_NEAR(result.gain, 1.0, 0.07);
    EXPECT_GT(result.inlier_share, 0.9);
  }
}

TEST(ImageAlignment, ConvergesFromMotionsOfUpToTwentyPixels) {
  Random random(3);
  int recovered = 0;
  for (int trial = 0; trial < 20; ++trial) {
    // 256 px of focal length and about 3 m of depth: 20 px are 0.078 rad, or 0.23 m.
    const double share = (trial + 1) / 20.0;
    Vector6d tangent = testing::random_vector<Vector6d>(random, 1.0);
    tangent.head<3>() *= 0.1 * share / tangent.head<3>().norm();
    tangent.tail<3>() *= 0.05 * share / tangent.tail<3>().norm();
    const SE3 truth = motion_of(tangent);
    const ImageAlignment result = align_from_rest(exact_reference(), image_at(truth));
    const Vector6d error = (truth.inverse() * result.image_from_reference).log();
    recovered += result.ok() && error.head<3>().norm() < 0.002 && error.tail<3>().norm() < 0.0006;
  }
  EXPECT_GE(recovered, 19);
}

TEST(ImageAlignment, RecoversARollThatTurnsTheGradients) {
  const SE3 truth = motion_of((Vector6d() << 0.02, 0.0, 0.03, 0.0, 0.0, 0.5).finished());
  const SE3 guess = truth * motion_of((Vector6d() << 0.01, -0.01, 0.01, 0.01, -0.01, 0.02).finished());
  const ImageAlignment result = align_image(exact_reference(), alignment_pyramid(image_at(truth), 5), guess);
  EXPECT_TRUE(result.ok());
  EXPECT_THAT(result.image_from_reference, pose_near(truth, 0.001, 0.0003));
}

TEST(ImageAlignment, ToleratesFivePercentOfErrorInTheInverseDepth) {
  const AlignmentReference reference =
      reference_of(reference_frame().gray, semi_dense_depth(reference_frame(), 5.0, 0.05, 2));
  for (const SE3& truth : {small_motion(), large_motion()}) {
    const ImageAlignment result = align_from_rest(reference, image_at(truth));
    EXPECT_TRUE(result.ok());
    EXPECT_THAT(result.image_from_reference, pose_near(truth, 0.003, 0.001));
  }
}

TEST(ImageAlignment, EstimatesGainAndOffset) {
  const SE3 truth = small_motion();
  struct Change {
    double gain, offset;
  };
  for (const Change& change : {Change{0.5, 0.0}, Change{2.0, 0.0}, Change{1.0, 30.0}, Change{0.7, 40.0}}) {
    const GrayImage image = exposed(image_at(truth), change.gain, change.offset, 0.0, 1);
    const ImageAlignment result = align_from_rest(exact_reference(), image);
    EXPECT_TRUE(result.ok()) << change.gain;
    EXPECT_THAT(result.image_from_reference, pose_near(truth, 0.002, 0.0005)) << change.gain;
    EXPECT_NEAR(result.gain, change.gain, 0.07 * change.gain);
    // The gain is low by the blur of interpolation, so what must be right is the brightness of a middle intensity.
    EXPECT_NEAR(result.gain * 80.0 + result.offset, change.gain * 80.0 + change.offset, 2.0);
  }
}

/// Mean of d^T covariance^-1 d over noisy images and depths: 6 if the covariance is right.
TEST(ImageAlignment, CovarianceFitsTheErrorsOfNoisyTrials) {
  const SE3 truth = small_motion();
  const GrayImage clean = image_at(truth);
  double sum = 0.0;
  constexpr int trials = 50;
  for (std::uint64_t trial = 0; trial < trials; ++trial) {
    const GrayImage noisy = exposed(reference_frame().gray, 1.0, 0.0, 4.0, 100 + trial);
    const AlignmentReference reference =
        reference_of(noisy, semi_dense_depth(reference_frame(), 8.0, 0.03, 200 + trial));
    const ImageAlignment result =
        align_image(reference, alignment_pyramid(exposed(clean, 1.0, 0.0, 4.0, 300 + trial), 5), truth);
    const Vector6d error = (result.image_from_reference.inverse() * truth).log();
    sum += error.dot(result.covariance.ldlt().solve(error));
  }
  RecordProperty("nees", std::to_string(sum / trials));
  EXPECT_GT(sum / trials, 3.0);
  EXPECT_LT(sum / trials, 10.0);
}

/// Neighbors with a common depth error are fewer independent observations: the covariance says so.
TEST(ImageAlignment, CovarianceGrowsWithTheCorrelationOfNeighbors) {
  const AlignmentReference independent =
      reference_of(reference_frame().gray, semi_dense_depth(reference_frame(), 5.0, 0.05, 7));
  InverseDepthMap patches = semi_dense_depth(reference_frame(), 5.0, 0.0, 7);
  Random random(9);
  for (int top = 0; top < patches.height(); top += 16) {
    for (int left = 0; left < patches.width(); left += 16) {
      const auto factor = static_cast<float>(1.0 + 0.05 * random.normal());
      for (int y = top; y < std::min(top + 16, patches.height()); ++y) {
        for (int x = left; x < std::min(left + 16, patches.width()); ++x) {
          patches.mean.at(x, y) *= factor;
          patches.variance.at(x, y) *= 25.0F;
        }
      }
    }
  }
  const GrayImage image = image_at(large_motion());
  const ImageAlignment one = align_from_rest(independent, image);
  const ImageAlignment other = align_from_rest(reference_of(reference_frame().gray, patches), image);
  EXPECT_GT(other.covariance.trace(), 2.0 * one.covariance.trace());
}

TEST(ImageAlignment, SaysWhyItFailed) {
  const GrayImage black(320, 240);
  EXPECT_EQ(align_from_rest(exact_reference(), black).failure, AlignmentFailure::too_few_points);
  EXPECT_EQ(align_from_rest(exact_reference(), testing::noise_image(320, 240, 5)).failure,
            AlignmentFailure::large_residual);
  const GrayImage elsewhere = alignment_room().render(motion_of((Vector6d() << 0, 0, 0, 0, 0.9, 0).finished())).gray;
  EXPECT_FALSE(align_from_rest(exact_reference(), elsewhere).ok());
  const SE3 turned = motion_of((Vector6d() << 0, 0, 0, 0, 2.5, 0).finished());
  EXPECT_EQ(align_image(exact_reference(), alignment_pyramid(reference_frame().gray, 5), turned).failure,
            AlignmentFailure::low_overlap);
  const AlignmentReference nothing = reference_of(reference_frame().gray, InverseDepthMap(320, 240));
  const ImageAlignment without = align_from_rest(nothing, reference_frame().gray);
  EXPECT_EQ(without.failure, AlignmentFailure::too_few_points);
  EXPECT_THAT(without.image_from_reference, pose_near(SE3(), 0.0, 0.0));
}

bool same_bytes(const ImageAlignment& a, const ImageAlignment& b) {
  return a.image_from_reference.matrix() == b.image_from_reference.matrix() && a.gain == b.gain &&
         a.covariance == b.covariance && a.rms == b.rms && a.points == b.points;
}

TEST(ImageAlignment, GivesTheSameBytesForAnyThreadsAndSimdLevel) {
  const Pyramid image = alignment_pyramid(image_at(large_motion()), 5);
  const ImageAlignment expected = align_image(exact_reference(), image, SE3());
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    EXPECT_TRUE(same_bytes(align_image(exact_reference(), image, SE3(), {}, &pool), expected)) << threads;
  }
  EXPECT_TRUE(
      same_bytes(testing::with_plain_code([&] { return align_image(exact_reference(), image, SE3()); }), expected));
}

}  // namespace
}  // namespace rastro
