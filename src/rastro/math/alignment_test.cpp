// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::random_vector;
using Points = std::vector<Eigen::Vector3d>;

Points cloud(Random& random, int count, double size) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(random_vector<Eigen::Vector3d>(random, size));
  return points;
}

Points moved(const Sim3& target_from_source, const Points& source) {
  Points target;
  for (const auto& point : source) target.push_back(target_from_source * point);
  return target;
}

TEST(Alignment, FindsTheSimilarity) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Sim3 ground_truth = Sim3::exp(random_vector<Vector7d>(random, 1.5));
    const Points source = cloud(random, 10, 3.0);
    const auto found = align_points(moved(ground_truth, source), source, AlignmentKind::similarity);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->unique);
    EXPECT_LT(found->rmse, 1e-12);
    EXPECT_THAT(found->target_from_source.matrix(), matrix_near(ground_truth.matrix(), 1e-11));
  }
}

TEST(Alignment, FindsTheRigidMotionAndKeepsScaleOne) {
  Random random(2);
  const SE3 ground_truth = SE3::exp(random_vector<Vector6d>(random, 1.5));
  const Points source = cloud(random, 30, 3.0);
  const auto found = align_points(moved(Sim3(ground_truth), source), source, AlignmentKind::rigid);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->target_from_source.scale(), 1.0);
  EXPECT_THAT(found->target_from_source.matrix(), matrix_near(ground_truth.matrix(), 1e-12));
}

TEST(Alignment, FindsTheYaw) {
  Random random(3);
  for (const double yaw : {-3.0, -0.2, 0.0, 1.0, 3.1}) {
    const SE3 ground_truth(SO3::exp({0.0, 0.0, yaw}), {1.0, -2.0, 3.0});
    const Points source = cloud(random, 5, 3.0);
    const auto found = align_points(moved(Sim3(ground_truth), source), source, AlignmentKind::yaw);
    ASSERT_TRUE(found);
    EXPECT_THAT(found->target_from_source.matrix(), matrix_near(ground_truth.matrix(), 1e-12));
  }
}

TEST(Alignment, NoOtherTransformFitsNoisyPointsBetter) {
  Random random(4);
  const Points source = cloud(random, 20, 2.0);
  Points target = moved(Sim3::exp(random_vector<Vector7d>(random, 1.0)), source);
  for (auto& point : target) point += random_vector<Eigen::Vector3d>(random, 0.3);
  const auto found = align_points(target, source, AlignmentKind::similarity);
  ASSERT_TRUE(found);
  for (int i = 0; i < 200; ++i) {
    const Sim3 other = found->target_from_source * Sim3::exp(random_vector<Vector7d>(random, 0.01));
    double sum = 0.0;
    for (std::size_t k = 0; k < source.size(); ++k) sum += (target[k] - other * source[k]).squaredNorm();
    EXPECT_LE(found->rmse, std::sqrt(sum / 20.0));
  }
}

TEST(Alignment, AgreesWithEigensUmeyama) {
  Random random(5);
  const Points source = cloud(random, 12, 2.0), target = cloud(random, 12, 2.0);
  Eigen::Matrix3Xd a(3, 12), b(3, 12);
  for (int i = 0; i < 12; ++i) {
    a.col(i) = source[i];
    b.col(i) = target[i];
  }
  const auto found = align_points(target, source, AlignmentKind::similarity);
  ASSERT_TRUE(found);
  EXPECT_THAT(found->target_from_source.matrix(), matrix_near(Eigen::Matrix4d(Eigen::umeyama(a, b, true)), 1e-12));
}

TEST(Alignment, AMirrorImageIsNeverAnAnswer) {
  Random random(6);
  const Points source = cloud(random, 12, 2.0);
  Points target = source;
  for (auto& point : target) point.x() = -point.x();
  const auto found = align_points(target, source, AlignmentKind::rigid);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->target_from_source.rotation().matrix().determinant(), 1.0, 1e-12);
  EXPECT_GT(found->rmse, 0.1);
}

TEST(Alignment, PointsOnALineAreAlignedButReportedAsNotUnique) {
  Points source, target;
  for (int i = 0; i < 10; ++i) {
    source.emplace_back(i, 0.0, 0.0);
    target.emplace_back(5.0, 2.0 * i, 1.0);
  }
  const auto found = align_points(target, source, AlignmentKind::similarity);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->unique);
  EXPECT_NEAR(found->target_from_source.scale(), 2.0, 1e-12);
  EXPECT_LT(found->rmse, 1e-12);
}

TEST(Alignment, WithoutAnAnswer) {
  const Points none, same(5, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_FALSE(align_points(none, none, AlignmentKind::rigid));
  EXPECT_FALSE(align_points(same, same, AlignmentKind::similarity));
  const auto translated = align_points(same, Points(5, Eigen::Vector3d::Zero()), AlignmentKind::rigid);
  ASSERT_TRUE(translated);
  EXPECT_FALSE(translated->unique);
  EXPECT_LT(translated->rmse, 1e-12);
  Points broken(5, Eigen::Vector3d::Zero());
  broken[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(align_points(same, broken, AlignmentKind::rigid));
}

}  // namespace
}  // namespace rastro
