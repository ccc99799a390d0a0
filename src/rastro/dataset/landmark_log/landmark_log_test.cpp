// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/landmark_log/landmark_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/dataset/check.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* log_text =
    "# a walk\n"
    "odometry 10.0 1.0 0.0\n"
    "odometry 12.0 0.5 0.25\n"
    "landmark 11.0 4 3.5 0.1\n"
    "landmark 11.0 - 2.0 -0.2\n"
    "landmark 14.0 4 2.5 0.3\n"
    "landmark 9.0 4 2.5 0.3\n";

TEST(LandmarkLog, ObservationsOfOneTimeAreOneFrameAndVelocitiesAreSummedUp) {
  const ScratchFolder folder;
  folder.write("walk.log", log_text);
  folder.write("groundtruth.txt", "9 0 0 0 0 0 0 1\n14 1 0 0 0 0 0 1\n");
  const auto source = open(folder.path("walk.log"));
  EXPECT_EQ(source->info().format, "landmark_log");
  EXPECT_EQ(source->info().frame_count, 3);
  EXPECT_TRUE(source->info().has_landmarks && source->info().has_odometry && !source->info().has_scan);
  EXPECT_THAT(source->info().warnings, IsEmpty());
  EXPECT_EQ(source->info().ground_truth.size(), 2u);
  const auto before = source->next(), first = source->next(), last = source->next();
  ASSERT_TRUE(before && first && last);
  EXPECT_FALSE(source->next());
  EXPECT_EQ(before->odometry_from_body->translation(), Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(first->stamp, 11'000'000'000);
  ASSERT_EQ(first->landmarks.size(), 2u);
  EXPECT_EQ(first->landmarks[0].id, 4);
  EXPECT_EQ(first->landmarks[1].id, -1);
  EXPECT_EQ(first->landmarks[1].bearing, -0.2);
  EXPECT_NEAR(first->odometry_from_body->translation().x(), 1.0, 1e-12);
  // 2 m straight, then 2 s on a circle of 2 m radius by half a radian.
  EXPECT_NEAR(last->odometry_from_body->translation().x(), 2.0 + 2.0 * std::sin(0.5), 1e-12);
  EXPECT_NEAR(last->odometry_from_body->translation().y(), 2.0 * (1.0 - std::cos(0.5)), 1e-12);
  EXPECT_NEAR(last->odometry_from_body->rotation().angle(), 0.5, 1e-12);
}

TEST(LandmarkLog, BrokenLinesAreLeftOutAndCounted) {
  const auto log = parse_landmark_log(
      "odometry 1 2 3\nodometry 1 2\nlandmark 1 x 2 3\nlandmark 2 7 -1 0\nwhat 1\n"
      "landmark 2 7 1 0 9\nlandmark 2 7 1 0\n",
      "a.log");
  EXPECT_EQ(log.velocities.size(), 1u);
  EXPECT_EQ(log.observations.size(), 1u);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_THAT(log.warnings[0], HasSubstr("5 lines skipped; the first: a.log:2: "));
  EXPECT_THAT(error_of([] { parse_landmark_log("# nothing\n", "a.log"); }), HasSubstr("only comments"));
  EXPECT_THAT(error_of([] { parse_landmark_log("odometry x\n", "a.log"); }), HasSubstr("a.log:1"));
}

TEST(LandmarkLog, WithoutAnObservationItIsAnError) {
  const ScratchFolder folder;
  folder.write("walk.log", "odometry 1 2 3\n");
  EXPECT_THAT(error_of([&] { open(folder.path("walk.log")); }), HasSubstr("has no landmark observations"));
}

TEST(Mrclam, ARobotsFilesBecomeOneRecording) {
  const ScratchFolder folder;
  folder.write("Robot2_Odometry.dat", "# Time [s] v w\n100.000 1.0 0.0\n101.000 0.0 0.0\n");
  folder.write("Robot2_Measurement.dat",
               "# Time subject range bearing\n100.5 72 3.0 0.5\n100.5 14 1.0 0.0\n"
               "101.5 99 2.0 0.0\n102.0 63 4.0 -0.5\n");
  folder.write("Barcodes.dat", "# Subject Barcode\n1 5\n2 14\n6 72\n7 63\n");
  folder.write("Robot2_Groundtruth.dat", "100.0 1.0 2.0 0.5\n102.0 2.0 2.0 0.5\n");
  for (const auto& path : {folder.path(), folder.path("Robot2_Measurement.dat")}) {
    const auto source = open(path);
    const auto& info = source->info();
    EXPECT_EQ(info.format, "mrclam");
    EXPECT_EQ(info.frame_count, 2);
    EXPECT_EQ(info.ground_truth.size(), 2u);
    EXPECT_THAT(info.warnings, Contains(HasSubstr("1 observations of other robots")));
    EXPECT_THAT(info.warnings, Contains(HasSubstr("1 observations of unknown barcodes")));
    const auto first = source->next(), last = source->next();
    ASSERT_TRUE(first && last);
    EXPECT_EQ(first->landmarks.front().id, 6);
    EXPECT_NEAR(first->odometry_from_body->translation().x(), 0.5, 1e-12);
    EXPECT_EQ(last->landmarks.front().id, 7);
    EXPECT_NEAR(last->odometry_from_body->translation().x(), 1.0, 1e-12);
  }
  const auto report = check(folder.path(), {});
  EXPECT_TRUE(report.usable);
  EXPECT_EQ(report.landmark_observations, 2);
  EXPECT_EQ(report.landmarks, 2);
  EXPECT_EQ(report.ground_truth_percent, 100.0);
}

}  // namespace
}  // namespace rastro
