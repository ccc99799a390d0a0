// SPDX-License-Identifier: Apache-2.0
// Published trajectories, which are not part of the project; skipped with a message if missing. The expected figures
// come from two independent programs.
#include <gtest/gtest.h>

#include <filesystem>

#include "rastro/base/recorded_data_testing.h"
#include "rastro/evaluate/trajectory_scores.h"

namespace rastro {
namespace {

constexpr const char* trajectories = "trajectories";

class PublishedFigures : public testing::Test {
 protected:
  void SetUp() override {
    if (!recorded_data(trajectories)) GTEST_SKIP() << no_recorded_data(trajectories);
  }
  static TrajectoryScores scores(const std::string& reference, const std::string& estimate,
                                 TrajectoryAlignment alignment) {
    TrajectoryScoreOptions options;
    options.alignment = alignment;
    options.rpe_deltas = {{10.0, RpeDelta::Unit::meters}};
    return score_trajectory(read_trajectory_input((recorded_data_path(trajectories) / reference).string()),
                            read_trajectory_input((recorded_data_path(trajectories) / estimate).string()), options);
  }
};

/// Half a unit of the ninth decimal, the precision of the figures.
constexpr double nine_decimals = 0.51e-9;

void expect_statistics(const ErrorStatistics& s, double rmse, double mean, double median, double max) {
  EXPECT_NEAR(s.rmse, rmse, nine_decimals);
  EXPECT_NEAR(s.mean, mean, nine_decimals);
  EXPECT_NEAR(s.median, median, nine_decimals);
  EXPECT_NEAR(s.max, max, nine_decimals);
}

TEST_F(PublishedFigures, Freiburg1XyzOfRgbdSlam) {
  const auto rigid = scores("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam.txt", TrajectoryAlignment::se3);
  EXPECT_EQ(rigid.pairing.matched, 786);
  EXPECT_EQ(rigid.scale(), 1.0);
  expect_statistics(*rigid.ate_m, 0.013473468, 0.012029476, 0.011175751, 0.034727202);
  const auto similar = scores("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam.txt", TrajectoryAlignment::sim3);
  EXPECT_NEAR(similar.scale(), 1.007923666, nine_decimals);
  EXPECT_NEAR(similar.ate_m->rmse, 0.013394055, nine_decimals);
}

TEST_F(PublishedFigures, Freiburg1XyzOfMonocularOrbKeyFrames) {
  const auto rigid = scores("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-ORB_kf_mono.txt", TrajectoryAlignment::se3);
  EXPECT_EQ(rigid.pairing.matched, 32);
  EXPECT_NEAR(rigid.ate_m->rmse, 0.024301632, nine_decimals);
  const auto similar =
      scores("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-ORB_kf_mono.txt", TrajectoryAlignment::sim3);
  EXPECT_NEAR(similar.scale(), 1.105622364, nine_decimals);
  EXPECT_NEAR(similar.ate_m->rmse, 0.009754582, nine_decimals);
  EXPECT_NEAR(similar.ate_m->max, 0.027924002, nine_decimals);
}

TEST_F(PublishedFigures, Freiburg2DeskOfOrb) {
  const auto rigid = scores("fr2_desk_groundtruth.txt", "fr2_desk_ORB.txt", TrajectoryAlignment::se3);
  EXPECT_EQ(rigid.pairing.matched, 2223);
  expect_statistics(*rigid.ate_m, 0.008143967, 0.007514459, 0.007431565, 0.024328989);
  const auto similar = scores("fr2_desk_groundtruth.txt", "fr2_desk_ORB.txt", TrajectoryAlignment::sim3);
  EXPECT_NEAR(similar.scale(), 0.997002288, nine_decimals);
  EXPECT_NEAR(similar.ate_m->rmse, 0.006185673, nine_decimals);
}

TEST_F(PublishedFigures, Freiburg2DeskOfMonocularOrbKeyFrames) {
  const auto similar = scores("fr2_desk_groundtruth.txt", "fr2_desk_ORB_kf_mono.txt", TrajectoryAlignment::sim3);
  EXPECT_EQ(similar.pairing.matched, 122);
  EXPECT_NEAR(similar.scale(), 2.228343751, nine_decimals);
  EXPECT_NEAR(similar.ate_m->rmse, 0.007899783, nine_decimals);
}

TEST_F(PublishedFigures, Kitti00OfOrb) {
  const auto rigid = scores("KITTI_00_gt.txt", "KITTI_00_ORB.txt", TrajectoryAlignment::se3);
  EXPECT_EQ(rigid.pairing.matched, 4541);
  EXPECT_TRUE(rigid.pairing.by_index);
  EXPECT_EQ(rigid.pairing.coverage_percent, 100.0);
  expect_statistics(*rigid.ate_m, 1.303449715, 1.156997129, 1.065624770, 3.587949121);
  EXPECT_NEAR(rigid.ate_m->min, 0.069313220, nine_decimals);
  EXPECT_EQ(rigid.segment_count, 3283);
  EXPECT_NEAR(*rigid.t_rel_percent, 0.699729, 0.51e-6);
  EXPECT_NEAR(*rigid.r_rel_deg_per_m, 0.00253330, 0.51e-8);
  EXPECT_NEAR(rigid.segments.front().translation_percent, 1.009038, 0.51e-6);
  EXPECT_NEAR(rigid.segments.back().translation_percent, 0.415861, 0.51e-6);
}

TEST_F(PublishedFigures, Kitti00RelativeErrorsOver10Meters) {
  const auto orb = scores("KITTI_00_gt.txt", "KITTI_00_ORB.txt", TrajectoryAlignment::none);
  expect_statistics(*orb.rpe.front().translation_m, 0.226261343, 0.169017372, 0.138484325, 1.272209078);
  const auto sptam = scores("KITTI_00_gt.txt", "KITTI_00_SPTAM.txt", TrajectoryAlignment::none);
  EXPECT_NEAR(sptam.rpe.front().translation_m->rmse, 0.276071090, nine_decimals);
  EXPECT_NEAR(sptam.rpe.front().translation_m->mean, 0.222847979, nine_decimals);
}

TEST_F(PublishedFigures, Kitti00OfSptam) {
  const auto rigid = scores("KITTI_00_gt.txt", "KITTI_00_SPTAM.txt", TrajectoryAlignment::se3);
  EXPECT_NEAR(rigid.ate_m->rmse, 3.738487908, nine_decimals);
  EXPECT_NEAR(rigid.ate_m->mean, 3.490976633, nine_decimals);
  EXPECT_NEAR(rigid.ate_m->max, 7.768977407, nine_decimals);
  EXPECT_NEAR(*rigid.t_rel_percent, 1.486961, 0.51e-6);
  EXPECT_NEAR(*rigid.r_rel_deg_per_m, 0.00557706, 0.51e-8);
}

}  // namespace
}  // namespace rastro
