// SPDX-License-Identifier: Apache-2.0
// The logs of the 2D SLAM benchmark (Kuemmerle et al. 2009) with their relations.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "rastro/base/recorded_data_testing.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/open.h"
#include "rastro/evaluate/relations.h"
#include "rastro/methods/methods.h"

namespace rastro {
namespace {

constexpr const char* laser_logs = "laser";

class LaserRelations : public testing::Test {
 protected:
  void SetUp() override {
    if (!recorded_data(laser_logs)) GTEST_SKIP() << no_recorded_data(laser_logs);
  }

  static std::unique_ptr<Source> open_log(const std::string& name) {
    return open((recorded_data_path(laser_logs) / (name + ".clf.gz")).string(), {});
  }

  static RelationScores scores_of(const std::string& name, Trajectory trajectory) {
    const std::string file = (recorded_data_path(laser_logs) / (name + ".relations")).string();
    // A few stamps of the logs go back.
    std::stable_sort(trajectory.begin(), trajectory.end(),
                     [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
    return score_relations(parse_relations(read_text_file(file), file), trajectory, 0);
  }

  static Trajectory odometry_of(const std::string& name) {
    Trajectory trajectory;
    const auto source = open_log(name);
    while (const auto frame = source->next()) {
      const SE2& pose = frame->odometry_from_body.value();
      trajectory.push_back({frame->stamp, SE3(SO3::exp(pose.rotation().angle() * Eigen::Vector3d::UnitZ()),
                                              {pose.translation().x(), pose.translation().y(), 0.0})});
    }
    return trajectory;
  }
};

TEST_F(LaserRelations, RawOdometryHasTheKnownErrors) {
  const RelationScores intel = scores_of("intel", odometry_of("intel"));
  EXPECT_EQ(intel.relations, 2984);
  EXPECT_EQ(intel.skipped, 0);
  EXPECT_NEAR(intel.trans_mean_m, 7.37, 0.005);
  const RelationScores aces = scores_of("aces", odometry_of("aces"));
  EXPECT_EQ(aces.relations, 1279);
  EXPECT_EQ(aces.skipped, 0);
  EXPECT_NEAR(aces.trans_mean_m, 0.55, 0.005);
}

TEST_F(LaserRelations, HectorFollowsTheFirstRoundOfIntel) {
  const auto source = open_log("intel");
  const auto slam = slam_method("hector")->make(source->info(), {});
  for (int k = 0; k < 2000; ++k) slam->process(source->next().value());
  slam->finish();
  const RelationScores scores = scores_of("intel", slam->trajectory());
  EXPECT_GT(scores.relations, 200) << "of the relations within these scans";
  EXPECT_LT(scores.trans_mean_m, 0.03);
  EXPECT_LT(scores.rot_mean_deg, 0.5);
}

}  // namespace
}  // namespace rastro
