// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/pose_consistency.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr TimeNs step = 100'000'000, within = 20'000'000;
constexpr int pose_count = 4000;

SE3 pose_on_curve(double t) {
  return {SO3::exp({0.1 * std::sin(t), 0.2 * std::sin(2 * t), 0.3 * t}),
          {5 * std::sin(t), 4 * std::sin(0.7 * t), 0.5 * t}};
}

Trajectory curve() {
  Trajectory trajectory;
  for (int k = 0; k < pose_count; ++k) trajectory.push_back({k * step, pose_on_curve(0.01 * k)});
  return trajectory;
}

Matrix6d covariance_of(double sigma) {
  Matrix6d root = Matrix6d::Identity();
  root(1, 0) = 0.8, root(2, 1) = -0.5, root(4, 3) = 0.3, root(5, 0) = 0.2;
  root.bottomRows<3>() *= 0.1;
  return sigma * sigma * root * root.transpose();
}

struct NoisyRun {
  Trajectory poses;
  std::vector<StampedCovariance> covariances;
};

/// Poses with normal errors of the covariance, which the run says `factor` times as large (in sigma).
NoisyRun noisy(const Trajectory& reference, double factor) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const Matrix6d covariance = covariance_of(0.02);
  const Matrix6d root = covariance.llt().matrixL();
  NoisyRun run;
  for (const StampedPose& pose : reference) {
    Vector6d unit;
    for (double& each : unit) each = normal(random);
    const Vector6d error = root * unit;
    run.poses.push_back({pose.stamp, SE3(SO3::exp(error.tail<3>()) * pose.world_from_body.rotation(),
                                         pose.world_from_body.translation() + error.head<3>())});
    run.covariances.push_back({pose.stamp, factor * factor * covariance});
  }
  return run;
}

PoseConsistency score(const Trajectory& reference, const Trajectory& final_poses, const NoisyRun& run,
                      double scale = 1.0) {
  return score_consistency({reference, final_poses, run.poses, run.covariances, scale, within});
}

TEST(PoseConsistency, ErrorsOfTheSaidSizeAreInside) {
  const Trajectory reference = curve();
  const PoseConsistency right = score(reference, reference, noisy(reference, 1.0));
  for (const auto& part : {right.position, right.rotation}) {
    ASSERT_TRUE(part);
    EXPECT_EQ(part->poses, pose_count);
    EXPECT_NEAR(part->inside_percent, 95.0, 1.2);
    EXPECT_NEAR(part->nees, 1.0, 0.05);
    EXPECT_NEAR(part->sigma_factor, 1.0, 0.04);
  }
}

TEST(PoseConsistency, SigmasTooSmallOrTooLargeAreSeen) {
  const Trajectory reference = curve();
  const PoseConsistency small = score(reference, reference, noisy(reference, 0.5));
  EXPECT_LT(small.position->inside_percent, 50.0);
  EXPECT_NEAR(small.position->sigma_factor, 2.0, 0.08);
  EXPECT_NEAR(small.rotation->nees, 4.0, 0.2);
  const PoseConsistency large = score(reference, reference, noisy(reference, 3.0));
  EXPECT_GT(large.rotation->inside_percent, 99.9);
  EXPECT_NEAR(large.rotation->sigma_factor, 1.0 / 3.0, 0.02);
}

TEST(PoseConsistency, WorldsMayDifferByAMotionAndAScale) {
  const Trajectory reference = curve();
  const NoisyRun run = noisy(reference, 1.0);
  const SE3 other_from_world(SO3::exp({0.5, -0.2, 1.0}), {10, -20, 3});
  Trajectory moved;
  for (const StampedPose& pose : reference) {
    const SE3 there = other_from_world * pose.world_from_body;
    moved.push_back({pose.stamp, SE3(there.rotation(), 4.0 * there.translation())});
  }
  // The curve begins at the identity, where the run's final poses say so too; its first poses there have noise.
  const PoseConsistency found = score(moved, reference, run, 4.0);
  EXPECT_NEAR(found.position->inside_percent, 95.0, 1.2);
  EXPECT_NEAR(found.rotation->inside_percent, 95.0, 1.2);
}

TEST(PoseConsistency, InThePlaneThereAreFewerFreedoms) {
  const Trajectory reference = curve();
  NoisyRun run = noisy(reference, 1.0);
  for (std::size_t k = 0; k < run.poses.size(); ++k) {
    Eigen::Vector3d position = run.poses[k].world_from_body.translation();
    position.z() = reference[k].world_from_body.translation().z();
    run.poses[k].world_from_body = SE3(run.poses[k].world_from_body.rotation(), position);
    run.covariances[k].covariance.row(2).setZero();
    run.covariances[k].covariance.col(2).setZero();
  }
  const PoseConsistency found = score(reference, reference, run);
  EXPECT_NEAR(found.position->inside_percent, 95.0, 1.2);
  EXPECT_NEAR(found.position->nees, 1.0, 0.06);
}

TEST(PoseConsistency, ReferenceIsTakenAtTheInstant) {
  const Trajectory reference = curve();
  NoisyRun run;
  for (int k = 1; k + 1 < pose_count; ++k) {
    run.poses.push_back({k * step + step / 10, pose_on_curve(0.01 * (k + 0.1))});
    run.covariances.push_back({k * step + step / 10, Matrix6d(1e-6 * Matrix6d::Identity())});
  }
  const PoseConsistency found = score_consistency({reference, reference, run.poses, run.covariances, 1.0, step});
  ASSERT_TRUE(found.position);
  EXPECT_EQ(found.position->poses, pose_count - 2);
  EXPECT_EQ(found.position->inside_percent, 100.0) << "5 mm of motion to the nearest pose, sigma 1 mm";
}

/// Lost halfway, the run ends with the larger part, which begins at an identity of its own and has no covariances.
TEST(PoseConsistency, PosesOfAPartThatIsNotTheFinalOneHaveTheirOwnOrigin) {
  const Trajectory reference = curve();
  NoisyRun run = noisy(reference, 1.0);
  constexpr std::size_t lost_at = 1000;
  const SE3 origin = reference[lost_at].world_from_body;
  Trajectory final_poses;
  for (std::size_t k = lost_at; k < reference.size(); ++k)
    final_poses.push_back({reference[k].stamp, origin.inverse() * reference[k].world_from_body});
  run.covariances.resize(lost_at);
  const SE3 start = reference.front().world_from_body;
  for (StampedPose& pose : run.poses) pose.world_from_body = start.inverse() * pose.world_from_body;
  for (StampedCovariance& covariance : run.covariances) {
    Matrix6d turned = Matrix6d::Zero();
    turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = start.rotation().matrix().transpose();
    covariance.covariance = turned * covariance.covariance * turned.transpose();
  }
  run.poses.front().world_from_body = SE3();
  const PoseConsistency part = score(reference, final_poses, run);
  ASSERT_TRUE(part.position && part.rotation);
  EXPECT_EQ(part.position->poses, static_cast<int>(lost_at));
  EXPECT_NEAR(part.position->inside_percent, 95.0, 2.5);
  EXPECT_NEAR(part.rotation->inside_percent, 95.0, 2.5);
}

TEST(PoseConsistency, NothingWithoutCommonStampsOrCovariances) {
  const Trajectory reference = curve();
  NoisyRun run = noisy(reference, 1.0);
  run.covariances.clear();
  EXPECT_FALSE(score(reference, reference, run).position);
  Trajectory later = reference;
  for (StampedPose& pose : later) pose.stamp += ns_per_second * 100'000;
  EXPECT_FALSE(score(later, reference, noisy(reference, 1.0)).rotation);
}

TEST(PoseConsistency, CovariancesAreReadAndFaultsNamed) {
  std::string line = "12.5";
  for (int k = 0; k < 21; ++k) line += fmt::format(" {}", k);
  const auto read = parse_pose_covariances("# head\n" + line + "\n", "file");
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].stamp, 12'500'000'000);
  EXPECT_EQ(read[0].covariance(0, 5), 5.0);
  EXPECT_EQ(read[0].covariance(5, 0), 5.0);
  EXPECT_EQ(read[0].covariance(1, 1), 6.0);
  EXPECT_EQ(read[0].covariance(5, 5), 20.0);
  for (const std::string& wrong : {line + " 1", std::string("12.5 1 2"), "nan" + line.substr(4), line + "x"})
    EXPECT_THROW(parse_pose_covariances(wrong + "\n", "file"), Error) << wrong;
}

}  // namespace
}  // namespace rastro
