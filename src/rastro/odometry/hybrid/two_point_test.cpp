// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/two_point.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/multiview/scene_testing.h"

namespace rastro {
namespace {

using testing::angle_between;
using testing::some_motion;
using testing::two_view_scene;

TEST(TwoPoint, GivesTheExactTranslation) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const SE3 motion(SO3::exp({random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)}),
                     {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
    const auto scene = two_view_scene(random, motion, {.count = 2});
    const auto found = translation_from_two_points(motion.rotation().matrix(), scene.points[0], scene.points[1],
                                                   scene.b[0], scene.b[1]);
    ASSERT_TRUE(found);
    EXPECT_LT((*found - motion.translation()).norm(), 1e-9);
  }
}

/// METHODS 2.3 as printed, in pixels.
TEST(TwoPoint, IsTheFormulaOfThePaper) {
  const double f = 721.5377, cx = 609.5593, cy = 172.854;
  const SE3 motion(SO3::exp({0.0, 0.03, 0.0}), {0.1, -0.02, -1.3});
  const Eigen::Vector3d point_a(-4.0, 1.0, 14.0), point_b(3.0, 0.5, 22.0);
  const auto pixel_of = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d p = motion * point;
    return Eigen::Vector2d(f * p.x() / p.z() + cx, f * p.y() / p.z() + cy);
  };
  const Eigen::Vector2d a = pixel_of(point_a), b = pixel_of(point_b);
  const Eigen::Matrix3d r = motion.rotation().matrix();
  const double a_z = (f * r.row(0) - (b.x() - cx) * r.row(2)).dot(point_b - point_a) / (b.x() - a.x());
  const Eigen::Vector3d by_paper((a.x() - cx) * a_z / f - r.row(0).dot(point_a),
                                 (a.y() - cy) * a_z / f - r.row(1).dot(point_a), a_z - r.row(2).dot(point_a));
  const auto normalized = [&](const Eigen::Vector2d& pixel) {
    return Eigen::Vector2d((pixel.x() - cx) / f, (pixel.y() - cy) / f);
  };
  const auto found = translation_from_two_points(r, point_a, point_b, normalized(a), normalized(b));
  ASSERT_TRUE(found);
  EXPECT_LT((*found - by_paper).norm(), 1e-9);
  EXPECT_LT((*found - motion.translation()).norm(), 1e-9);
}

TEST(TwoPoint, UsesTheOtherAxisAndRefusesCoincidence) {
  const Eigen::Matrix3d straight = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d point_a(1.0, -1.0, 10.0), point_b(2.0, 4.0, 20.0), t(0.0, 0.0, 0.0);
  const Eigen::Vector2d a = point_a.hnormalized(), b = point_b.hnormalized();
  ASSERT_EQ(a.x(), b.x());
  const auto found = translation_from_two_points(straight, point_a, point_b, a, b);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - t).norm(), 1e-12);
  EXPECT_FALSE(translation_from_two_points(straight, point_a, point_b, a, a));
}

TEST(EstimateTranslation, IsRobustToNoiseAndOutliers) {
  Random random(2);
  const auto scene = two_view_scene(random, some_motion(), {.count = 200, .noise_px = 0.3, .outlier_share = 0.4});
  const CalibratedRansacOptions options{{.max_error_px = 2.0}, 500.0};
  const auto fit = estimate_translation(some_motion().rotation().matrix(), scene.points, scene.b, options);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->translation - some_motion().translation()).norm(), 0.01);
  int wrong = 0;
  for (std::size_t i = 0; i < scene.b.size(); ++i) wrong += (fit->is_inlier[i] != 0) == scene.is_outlier[i] ? 1 : 0;
  EXPECT_LT(wrong, 6);
  const auto again = estimate_translation(some_motion().rotation().matrix(), scene.points, scene.b, options);
  EXPECT_EQ(fit->translation, again->translation);
}

TEST(EstimateTranslation, NeedsTwoPoints) {
  const std::vector<Eigen::Vector3d> point{{0, 0, 5}};
  const std::vector<Eigen::Vector2d> seen{{0, 0}};
  EXPECT_FALSE(estimate_translation(Eigen::Matrix3d::Identity(), point, seen, {}));
  EXPECT_FALSE(estimate_translation(Eigen::Matrix3d::Identity(), {}, {}, {}));
}

TEST(EstimateDirection, FindsDirectionAndSign) {
  Random random(3);
  for (const Eigen::Vector3d& t :
       {Eigen::Vector3d(0.2, 0.0, -1.0), Eigen::Vector3d(-0.1, 0.1, 1.0), Eigen::Vector3d(1.0, 0.0, 0.0)}) {
    const SE3 motion(SO3::exp({0.01, 0.1, -0.02}), t);
    const auto scene = two_view_scene(random, motion, {.count = 200, .noise_px = 0.3, .outlier_share = 0.3});
    const CalibratedRansacOptions options{{.max_error_px = 1.5}, 500.0};
    const auto fit = estimate_direction(motion.rotation().matrix(), scene.a, scene.b, options);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->translation.norm(), 1.0, 1e-12);
    EXPECT_LT(angle_between(fit->translation, t), 0.025) << t.transpose();
  }
}

TEST(EstimateDirection, APureRotationHasNone) {
  Random random(4);
  const SE3 rotation_only(SO3::exp({0.0, 0.1, 0.0}), Eigen::Vector3d::Zero());
  const auto scene = two_view_scene(random, rotation_only, {.count = 50});
  const auto fit = estimate_direction(rotation_only.rotation().matrix(), scene.a, scene.b, {});
  if (fit) {
    EXPECT_TRUE(fit->translation.allFinite());
  }
  EXPECT_FALSE(estimate_direction(rotation_only.rotation().matrix(), {}, {}, {}));
}

}  // namespace
}  // namespace rastro
