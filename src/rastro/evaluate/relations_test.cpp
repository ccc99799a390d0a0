// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/relations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

using testing::HasSubstr;

SE3 planar(double x, double y, double yaw) { return {SO3::exp(yaw * Eigen::Vector3d::UnitZ()), {x, y, 0.0}}; }

std::string message_of(const std::string& text) {
  try {
    parse_relations(text, "some.relations");
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(Relations, AreReadToTheNanosecond) {
  const auto relations = parse_relations(
      "# two\n976052905.167303 976052911.885496 -0.056990 -0.128430 0 0 0 -1.682210\n\n1.5 2 1 2 3 0.1 0.2 0.3\n", "x");
  ASSERT_EQ(relations.size(), 2U);
  EXPECT_EQ(relations[0].stamp_a, 976'052'905'167'303'000);
  EXPECT_EQ(relations[0].stamp_b, 976'052'911'885'496'000);
  EXPECT_NEAR(relations[0].a_from_b.rotation().log().z(), -1.682210, 1e-12);
  EXPECT_NEAR(relations[0].a_from_b.translation().y(), -0.128430, 1e-15);
  const Eigen::Matrix3d rotation = relations[1].a_from_b.rotation().matrix();
  EXPECT_NEAR(std::atan2(rotation(1, 0), rotation(0, 0)), 0.3, 1e-12) << "yaw";
  EXPECT_NEAR(std::asin(-rotation(2, 0)), 0.2, 1e-12) << "pitch";
  EXPECT_NEAR(std::atan2(rotation(2, 1), rotation(2, 2)), 0.1, 1e-12) << "roll";
}

TEST(Relations, RefusesOtherText) {
  EXPECT_THAT(message_of("1 2 3\n"), HasSubstr("some.relations:1"));
  EXPECT_THAT(message_of("1 2 0 0 0 0 0 0\n1 2 0 0 0 0 0 nan\n"), HasSubstr("some.relations:2"));
  EXPECT_THAT(message_of("one 2 0 0 0 0 0 0\n"), HasSubstr("'one'"));
  EXPECT_THAT(message_of("1 9e18 0 0 0 0 0 0\n"), HasSubstr("stamp"));
  EXPECT_THAT(message_of("# nothing\n"), HasSubstr("no relations"));
}

TEST(Relations, AreZeroForTheGroundTruthInAnyFrame) {
  Random random(3);
  Trajectory trajectory;
  std::vector<Relation> relations;
  const SE3 elsewhere = planar(40.0, -7.0, 2.0);
  for (int k = 0; k < 20; ++k)
    trajectory.push_back({k * ns_per_second,
                          elsewhere * planar(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), random.uniform())});
  for (std::size_t k = 3; k < 20; ++k) {
    const StampedPose &a = trajectory[k], &b = trajectory[k / 2];
    relations.push_back({a.stamp, b.stamp, a.world_from_body.inverse() * b.world_from_body});
  }
  const RelationScores scores = score_relations(relations, trajectory, 0);
  EXPECT_EQ(scores.relations, 17);
  EXPECT_EQ(scores.skipped, 0);
  EXPECT_NEAR(scores.trans_mean_m, 0.0, 1e-12);
  EXPECT_NEAR(scores.rot_mean_deg, 0.0, 1e-6);
}

TEST(Relations, MeanAndSigmaByHand) {
  const Trajectory trajectory = {
      {0, {}}, {ns_per_second, planar(1.0, 0.0, 0.1)}, {2 * ns_per_second, planar(4.0, 0.0, 0.0)}};
  // Errors of 0.2 m and 0.1 rad, and of 0.4 m and none.
  const std::vector<Relation> relations = {{0, ns_per_second, planar(0.8, 0.0, 0.0)},
                                           {0, 2 * ns_per_second, planar(4.0, 0.4, 0.0)}};
  const RelationScores scores = score_relations(relations, trajectory, 0);
  EXPECT_NEAR(scores.trans_mean_m, 0.3, 1e-12);
  EXPECT_NEAR(scores.trans_sigma_m, 0.1, 1e-12);
  EXPECT_NEAR(scores.worst_trans_m, 0.4, 1e-12);
  const double degrees = 0.1 * 180.0 / std::numbers::pi;
  EXPECT_NEAR(scores.rot_mean_deg, degrees / 2.0, 1e-9);
  EXPECT_NEAR(scores.rot_sigma_deg, degrees / 2.0, 1e-9);
}

TEST(Relations, UsesTheNearestPoseAndSkipsIfNoneIsNear) {
  const Trajectory trajectory = {{0, {}}, {1000, planar(1.0, 0.0, 0.0)}, {3000, planar(2.0, 0.0, 0.0)}};
  const std::vector<Relation> relations = {{40, 1900, planar(1.0, 0.0, 0.0)}, {0, 9000, planar(5.0, 0.0, 0.0)}};
  const RelationScores scores = score_relations(relations, trajectory, 900);
  EXPECT_EQ(scores.relations, 1);
  EXPECT_EQ(scores.skipped, 1);
  EXPECT_EQ(scores.worst_dt, 900);
  EXPECT_NEAR(scores.trans_mean_m, 0.0, 1e-12) << "1900 is nearer to 1000 than to 3000";
  const RelationScores none = score_relations(relations, {}, 900);
  EXPECT_EQ(none.relations, 0);
  EXPECT_EQ(none.skipped, 2);
}

}  // namespace
}  // namespace rastro
