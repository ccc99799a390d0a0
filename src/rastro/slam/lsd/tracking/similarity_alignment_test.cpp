// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/similarity_alignment.h"

#include <gtest/gtest.h>

#include "rastro/image/image_testing.h"
#include "rastro/math/math_testing.h"
#include "rastro/slam/lsd/tracking/alignment_testing.h"
#include "rastro/slam/lsd/tracking/similarity_residuals.h"

namespace rastro {
namespace {

/// A keyframe of the room whose map has a unit of `meters_per_unit`.
struct RenderedKeyframe {
  RenderedFrame frame;
  Pyramid image;
  AlignmentReference reference;

  RenderedKeyframe(const SE3& world_from_camera, double meters_per_unit, double relative_sigma, std::uint64_t seed) {
    static testing::AlignmentRoom room;
    frame = room.render(world_from_camera);
    image = alignment_pyramid(frame.gray, 5);
    InverseDepthMap depth = testing::semi_dense_depth(frame, 5.0, relative_sigma, seed);
    const auto factor = static_cast<float>(meters_per_unit);
    for (int y = 0; y < depth.height(); ++y) {
      for (int x = 0; x < depth.width(); ++x) {
        depth.mean.at(x, y) *= factor;
        depth.variance.at(x, y) *= factor * factor;
      }
    }
    reference.build(image, depth, room.camera());
  }
  SimilarityTarget target() const { return {image, reference.depth()}; }
};

SE3 world_from_b() { return SE3::exp((Vector6d() << 0.06, -0.02, 0.05, 0.01, -0.02, 0.03).finished()); }

const RenderedKeyframe& keyframe_a() {
  static const RenderedKeyframe keyframe(SE3(), 1.0, 0.0, 1);
  return keyframe;
}
/// In a unit of 1.25 m.
const RenderedKeyframe& keyframe_b() {
  static const RenderedKeyframe keyframe(world_from_b(), 1.25, 0.0, 2);
  return keyframe;
}
Sim3 true_b_from_a() { return Sim3(1.0 / 1.25, SO3(), Eigen::Vector3d::Zero()) * Sim3(world_from_b().inverse()); }

double scale_error(const Sim3& estimated, const Sim3& truth) {
  return std::abs(estimated.scale() / truth.scale() - 1.0);
}

TEST(SimilarityAlignment, RecoversMotionAndScale) {
  const SimilarityAlignment result = align_similarity(keyframe_a().reference, keyframe_b().target(), Sim3());
  EXPECT_TRUE(result.ok()) << to_string(result.failure);
  EXPECT_TRUE(result.converged);
  EXPECT_LT(scale_error(result.b_from_a, true_b_from_a()), 0.005);
  const Vector7d error = (result.b_from_a.inverse() * true_b_from_a()).log();
  EXPECT_LT(error.head<3>().norm(), 0.004);
  EXPECT_LT(error.segment<3>(3).norm(), 0.001);
  EXPECT_GT(result.overlap, 0.8);
  EXPECT_GT(result.depth_points, result.points / 3);
}

TEST(SimilarityAlignment, RecoversTheScaleFromNoisyDepths) {
  const RenderedKeyframe a(SE3(), 1.0, 0.05, 3), b(world_from_b(), 1.25, 0.05, 4);
  const SimilarityAlignment result = align_similarity(a.reference, b.target(), Sim3());
  EXPECT_TRUE(result.ok()) << to_string(result.failure);
  EXPECT_LT(scale_error(result.b_from_a, true_b_from_a()), 0.005);
}

TEST(SimilarityAlignment, BothDirectionsAgree) {
  const SimilarityAlignment forward = align_similarity(keyframe_a().reference, keyframe_b().target(), Sim3());
  const SimilarityAlignment backward = align_similarity(keyframe_b().reference, keyframe_a().target(), Sim3());
  const auto error = reciprocal_error(forward, backward);
  ASSERT_TRUE(error);
  RecordProperty("reciprocal", std::to_string(*error));
  EXPECT_LT(*error, 30.0);
  SimilarityAlignment wrong = forward;
  wrong.b_from_a = forward.b_from_a * Sim3::exp((Vector7d() << 0.1, 0, 0, 0, 0, 0, 0.1).finished());
  EXPECT_GT(*reciprocal_error(wrong, backward), 1000.0);
}

TEST(SimilarityAlignment, SaysWhyItFailed) {
  const Pyramid noise = alignment_pyramid(testing::noise_image(320, 240, 3), 5);
  EXPECT_EQ(align_similarity(keyframe_a().reference, {noise, keyframe_b().reference.depth()}, Sim3()).failure,
            AlignmentFailure::large_residual);
  const Sim3 turned(SE3::exp((Vector6d() << 0, 0, 0, 0, 2.5, 0).finished()));
  EXPECT_EQ(align_similarity(keyframe_a().reference, keyframe_b().target(), turned).failure,
            AlignmentFailure::low_overlap);
  const auto unknown = inverse_depth_pyramid(InverseDepthMap(320, 240), 5);
  const SimilarityAlignment without = align_similarity(keyframe_a().reference, {keyframe_b().image, unknown}, Sim3());
  EXPECT_EQ(without.failure, AlignmentFailure::too_few_points);
  EXPECT_FALSE(reciprocal_error(without, without));
}

/// The mean of chi-squared with 7 degrees of freedom is 7.
TEST(ReciprocalError, IsChiSquaredForRightInformation) {
  Random random(4);
  const Sim3 truth = Sim3::exp((Vector7d() << 0.5, -0.3, 0.2, 0.2, 0.1, -0.4, 0.3).finished());
  SimilarityAlignment forward, backward;
  const Vector7d sigma = (Vector7d() << 2, 1, 3, 1, 1, 2, 4).finished() * 1e-3;
  forward.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  backward.information = 4.0 * forward.information;
  const auto draw = [&](double scale) {
    Vector7d d;
    for (int i = 0; i < 7; ++i) d[i] = scale * sigma[i] * random.normal();
    return d;
  };
  double sum = 0.0;
  constexpr int trials = 2000;
  for (int trial = 0; trial < trials; ++trial) {
    forward.b_from_a = truth * Sim3::exp(draw(1.0));
    backward.b_from_a = truth.inverse() * Sim3::exp(draw(0.5));
    sum += *reciprocal_error(forward, backward);
  }
  EXPECT_NEAR(sum / trials, 7.0, 0.4);
}

/// Depths of both keyframes are metric: no residual may change the scale, and it counts as known.
TEST(SimilarityAlignment, AHeldScaleStaysWhatItIs) {
  SimilarityAlignmentOptions options;
  options.fix_scale = true;
  const Sim3 guess = true_b_from_a() * Sim3::exp((Vector7d() << 0.01, 0.0, 0.01, 0.002, 0.0, 0.001, 0.02).finished());
  const SimilarityTarget target{keyframe_b().image, keyframe_b().reference.depth()};
  const SimilarityAlignment held = align_similarity(keyframe_a().reference, target, guess, options),
                            free = align_similarity(keyframe_a().reference, target, guess);
  EXPECT_NEAR(held.b_from_a.scale(), guess.scale(), 1e-12 * guess.scale());
  EXPECT_GT(std::abs(free.b_from_a.scale() / guess.scale() - 1.0), 0.005);
  EXPECT_GT(held.information(6, 6), 1e4 * free.information(6, 6));
}

/// The inverse depth is smooth, so its residual can be differentiated as it is; nearest pixels must not change.
TEST(SimilarityResiduals, InverseDepthDerivativesAreThoseOfFiniteDifferences) {
  const SimilarityResiduals residuals(keyframe_a().reference.level(0), keyframe_b().image.level(0),
                                      keyframe_b().reference.depth()[0], {});
  const SimilarityState state{true_b_from_a() * Sim3::exp(0.01 * Vector7d::Ones()), {}};
  int compared = 0;
  for (int point = 0; point < keyframe_a().reference.level(0).count; point += 97) {
    const SimilarityResidual here = residuals.residual(point, state);
    if (!here.has_depth) continue;
    for (int k = 0; k < 7; ++k) {
      SimilarityResiduals::Step d = SimilarityResiduals::Step::Zero();
      d[k] = 1e-7;
      const SimilarityResidual plus = residuals.residual(point, SimilarityResiduals::retract(state, d));
      const SimilarityResidual minus = residuals.residual(point, SimilarityResiduals::retract(state, -d));
      if (!plus.has_depth || !minus.has_depth) continue;
      const double expected = (plus.inverse_depth - minus.inverse_depth) / 2e-7;
      // Larger: the nearest pixel changed.
      if (std::abs(expected) > 10.0) continue;
      EXPECT_NEAR(here.by_state_inverse_depth[k], expected, 1e-5);
      ++compared;
    }
  }
  EXPECT_GT(compared, 200);
}

/// With scale 1 the photometric part is that of the rigid alignment.
TEST(SimilarityResiduals, PhotometricPartIsThatOfTheKernels) {
  const AlignmentPoints& points = keyframe_a().reference.level(1);
  const SE3 pose = world_from_b().inverse();
  const SimilarityResiduals residuals(points, keyframe_b().image.level(1), keyframe_b().reference.depth()[1], {});
  const AlignmentView view = alignment_view(keyframe_b().image.level(1), points.camera, pose, 1.1, 120.0, {});
  AlignmentColumns columns;
  alignment_kernels().linearize(points, 0, alignment_chunk, view, columns);
  for (int i = 0; i < alignment_chunk; ++i) {
    const SimilarityResidual one = residuals.residual(i, {Sim3(pose), {1.1, 120.0}});
    ASSERT_EQ(one.used, columns.weight[i] != 0.0F);
    if (!one.used) continue;
    EXPECT_NEAR(one.intensity, columns.column[8][i], 0.02);
    for (int k = 0; k < 6; ++k) {
      const auto expected = static_cast<double>(columns.column[k][i]);
      EXPECT_NEAR(one.by_state_intensity[k], expected, 1e-2 + 1e-4 * std::abs(expected));
    }
    EXPECT_EQ(one.by_state_intensity[7], columns.column[6][i]);
  }
}

}  // namespace
}  // namespace rastro
