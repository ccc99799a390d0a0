// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/essential.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "rastro/multiview/rotation.h"
#include "rastro/multiview/scene_testing.h"

namespace rastro {
namespace {

using testing::angle_between;
using testing::some_motion;
using testing::two_view_scene;

CalibratedRansacOptions ransac_options() { return {{1.0, 0.999, 1000, 7}, 500.0}; }

double rotation_error(const SE3& a, const SE3& b) { return (a.rotation().inverse() * b.rotation()).log().norm(); }

TEST(EssentialFromFive, OneOfTheModelsIsTheTrueOneForAnyMotion) {
  Random random(1);
  const std::uint32_t indices[5] = {0, 1, 2, 3, 4};
  int found = 0, unsound = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const SE3 motion(SO3::exp({random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)}),
                     {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
    const auto scene = two_view_scene(random, motion, {.count = 5});
    const Eigen::Matrix3d ground_truth = essential_of(motion) / std::sqrt(2.0);
    double nearest = 1.0;
    for (const auto& e : essential_from_five(scene.a, scene.b, indices)) {
      unsound += std::abs(e.determinant()) > 1e-5;
      nearest = std::min({nearest, (e - ground_truth).norm(), (e + ground_truth).norm()});
    }
    found += nearest < 1e-6;
  }
  // Double roots may be missed, and the roots beside them are poor.
  EXPECT_GE(found, 195);
  EXPECT_LE(unsound, 2);
}

TEST(EstimateEssential, IsExactWithoutNoise) {
  Random random(2);
  const auto scene = two_view_scene(random, some_motion(), {.count = 60});
  const auto fit = estimate_essential(scene.a, scene.b, ransac_options());
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers, 60);
  EXPECT_EQ(fit->in_front, 60);
  EXPECT_LT(rotation_error(fit->second_from_first, scene.second_from_first), 1e-8);
  EXPECT_LT(angle_between(fit->second_from_first.translation(), scene.second_from_first.translation()), 1e-8);
  EXPECT_NEAR(fit->second_from_first.translation().norm(), 1.0, 1e-12);
}

TEST(EstimateEssential, APlaneGivesTheTrueMotionOrItsTwin) {
  Random random(2);
  const auto scene = two_view_scene(random, some_motion(), {.count = 60, .planar = true});
  const auto fit = estimate_essential(scene.a, scene.b, ransac_options());
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers, 60);
  EXPECT_EQ(fit->in_front, 60);
  for (std::size_t i = 0; i < scene.a.size(); ++i) {
    EXPECT_NEAR(scene.b[i].homogeneous().dot(fit->essential * scene.a[i].homogeneous()), 0.0, 1e-10);
  }
}

TEST(EstimateEssential, IsRobustToNoiseAndFortyPercentOutliers) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const auto scene = two_view_scene(random, some_motion(), {.count = 300, .noise_px = 0.3, .outlier_share = 0.4});
    const auto fit = estimate_essential(scene.a, scene.b, ransac_options());
    ASSERT_TRUE(fit);
    EXPECT_LT(rotation_error(fit->second_from_first, scene.second_from_first), 2e-3) << "seed " << seed;
    EXPECT_LT(angle_between(fit->second_from_first.translation(), scene.second_from_first.translation()), 0.03)
        << "seed " << seed;
    int kept_false = 0, lost_true = 0;
    for (std::size_t i = 0; i < scene.a.size(); ++i) {
      kept_false += scene.is_outlier[i] && fit->is_inlier[i] != 0;
      lost_true += !scene.is_outlier[i] && fit->is_inlier[i] == 0;
    }
    EXPECT_LE(kept_false, 8);  // near their epipolar line by chance
    EXPECT_LE(lost_true, 6);
  }
}

TEST(EstimateEssential, MeasuresTheParallaxOfTheMotion) {
  Random random(4);
  const SE3 sideways(SO3::exp({0.0, 0.1, 0.0}), {1.0, 0.0, 0.0});
  const auto scene = two_view_scene(random, sideways, {.count = 200});
  std::vector<double> angles;
  for (const auto& p : scene.points) {
    const Eigen::Vector3d center = sideways.inverse().translation();
    angles.push_back(angle_between(p, p - center) * 180.0 / std::numbers::pi);
  }
  std::sort(angles.begin(), angles.end());
  const auto fit = estimate_essential(scene.a, scene.b, ransac_options());
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->median_parallax_deg, angles[100], 1e-6);
}

TEST(EstimateEssential, WithoutTranslationTheParallaxIsZero) {
  for (const Eigen::Vector3d& rotation : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.02, 0.1, -0.03)}) {
    Random random(5);
    const auto scene = two_view_scene(random, SE3(SO3::exp(rotation), Eigen::Vector3d::Zero()),
                                      {.count = 200, .noise_px = 0.2, .outlier_share = 0.1});
    const auto fit = estimate_essential(scene.a, scene.b, ransac_options());
    ASSERT_TRUE(fit);
    EXPECT_LT(fit->median_parallax_deg, 0.2);
    EXPECT_LT((fit->second_from_first.rotation().inverse() * SO3::exp(rotation)).log().norm(), 0.02);
  }
}

TEST(EstimateEssential, TooFewOrRandomPairsGiveNone) {
  Random random(6);
  const auto scene = two_view_scene(random, some_motion(), {.count = 4});
  EXPECT_FALSE(estimate_essential(scene.a, scene.b, ransac_options()));
  EXPECT_FALSE(estimate_essential({}, {}, ransac_options()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector2d> nonsense(20, Eigen::Vector2d(nan, 1.0));
  EXPECT_FALSE(estimate_essential(nonsense, nonsense, ransac_options()));
  const std::vector<Eigen::Vector2d> same(20, Eigen::Vector2d(0.1, 0.2));
  if (const auto fit = estimate_essential(same, same, ransac_options())) {
    EXPECT_TRUE(fit->essential.allFinite());
    EXPECT_TRUE(fit->second_from_first.matrix().allFinite());
  }
}

TEST(EstimateEssential, ARepeatedFrameGivesNoImplausiblePose) {
  Random random(7);
  const auto scene = two_view_scene(random, SE3(), {.count = 100});
  if (const auto fit = estimate_essential(scene.a, scene.b, ransac_options())) {
    EXPECT_TRUE(fit->second_from_first.matrix().allFinite());
  }
  const auto rotation = rotation_between(scene.a, scene.b, ransac_options());
  ASSERT_TRUE(rotation);
  EXPECT_EQ(rotation->inliers, 100);
  EXPECT_LT(rotation->second_from_first.log().norm(), 1e-12);
}

TEST(EstimateEssential, SameSeedSameBits) {
  Random random(8);
  const auto scene = two_view_scene(random, some_motion(), {.count = 150, .noise_px = 0.3, .outlier_share = 0.3});
  const auto first = estimate_essential(scene.a, scene.b, ransac_options());
  const auto second = estimate_essential(scene.a, scene.b, ransac_options());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->essential, second->essential);
  EXPECT_EQ(first->second_from_first.matrix(), second->second_from_first.matrix());
  EXPECT_EQ(first->is_inlier, second->is_inlier);
}

TEST(RecoverPose, FindsEachOfTheFourMotions) {
  Random random(9);
  for (const Eigen::Vector3d& t :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0.2, 0), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.1, 0, 1)}) {
    const SE3 motion(SO3::exp({0.05, -0.1, 0.02}), t);
    const auto scene = two_view_scene(random, motion, {.count = 50});
    for (const double sign : {1.0, -3.0}) {
      const auto pose = recover_pose(sign * essential_of(motion), scene.a, scene.b, {});
      ASSERT_TRUE(pose);
      EXPECT_EQ(pose->in_front, 50);
      EXPECT_LT(pose->runner_up, 50);
      EXPECT_LT(rotation_error(pose->second_from_first, motion), 1e-8);
      EXPECT_LT(angle_between(pose->second_from_first.translation(), t), 1e-8);
    }
  }
}

TEST(RefineRelativePose, ConvergesFromAPerturbedStart) {
  Random random(10);
  const auto scene = two_view_scene(random, some_motion(), {.count = 50});
  const SE3 start = SE3::exp((Vector6d() << 0.1, -0.1, 0.05, 0.01, -0.02, 0.01).finished()) * some_motion();
  const auto refined = refine_relative_pose(start, scene.a, scene.b, {});
  ASSERT_TRUE(refined);
  EXPECT_LT(rotation_error(*refined, some_motion()), 1e-10);
  EXPECT_LT(angle_between(refined->translation(), some_motion().translation()), 1e-10);
  EXPECT_FALSE(refine_relative_pose(SE3(), scene.a, scene.b, {}));
}

TEST(RotationBetween, IsExactAndRobustToOutliers) {
  const SO3 rotation = SO3::exp({0.05, -0.2, 0.1});
  Random random(11);
  const auto exact = two_view_scene(random, SE3(rotation, Eigen::Vector3d::Zero()), {.count = 40});
  const auto fit = rotation_between(exact.a, exact.b, ransac_options());
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->second_from_first.inverse() * rotation).log().norm(), 1e-10);
  EXPECT_LT(fit->median_error_px, 1e-3);
  const auto noisy = two_view_scene(random, SE3(rotation, Eigen::Vector3d::Zero()),
                                    {.count = 200, .noise_px = 0.3, .outlier_share = 0.4});
  const auto robust = rotation_between(noisy.a, noisy.b, ransac_options());
  ASSERT_TRUE(robust);
  EXPECT_LT((robust->second_from_first.inverse() * rotation).log().norm(), 2e-4);
  for (std::size_t i = 0; i < noisy.a.size(); ++i) {
    if (noisy.is_outlier[i]) continue;
    EXPECT_LT((noisy.b[i] - (rotation * noisy.points[i]).hnormalized()).norm(), 0.01);
  }
}

TEST(RotationBetween, DoesNotFitATranslation) {
  Random random(12);
  const auto scene = two_view_scene(random, some_motion(), {.count = 200});
  const auto fit = rotation_between(scene.a, scene.b, ransac_options());
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->inliers, 60);
  EXPECT_GT(fit->median_error_px, 3.0);
  EXPECT_FALSE(rotation_between(std::span(scene.a).first(1), std::span(scene.b).first(1), ransac_options()));
}

}  // namespace
}  // namespace rastro
