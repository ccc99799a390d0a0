// SPDX-License-Identifier: Apache-2.0
// Recorded drives, which are not part of the project: skipped with a message where they are missing.
#include "rastro/odometry/profiles/profiles_odometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/recorded_data_testing.h"
#include "rastro/base/text_file.h"
#include "rastro/registration/profiles/calibrate_yaw.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

struct RecordedDrive {
  const char* folder;
  int frames;
  Camera camera;
  double max_yaw_rms_deg;   ///< Between consecutive frames.
  double max_yaw_end_deg;   ///< Accumulated.
  double max_lambda_error;  ///< Of the calibrated lambda against 1 / fx, as a share.
};

void PrintTo(const RecordedDrive& drive, std::ostream* out) { *out << drive.folder; }

class ProfilesOnRecorded : public testing::TestWithParam<RecordedDrive> {};

std::optional<Frame> read_image(const std::filesystem::path& file, int index) {
  const cv::Mat gray = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (gray.empty()) return std::nullopt;
  Frame frame;
  frame.index = index;
  frame.stamp = index * 100'000'000LL;
  frame.image = GrayImage(gray.cols, gray.rows);
  for (int y = 0; y < gray.rows; ++y) std::copy_n(gray.ptr(y), gray.cols, frame.image.row(y));
  return frame;
}

std::optional<Frame> read_frame(const std::filesystem::path& folder, int index) {
  char name[16];
  std::snprintf(name, sizeof name, "%06d.png", index);
  return read_image(folder / "image_0" / name, index);
}

/// Yaw to the left between two poses of KITTI's camera.
double yaw_between(const SE3& a, const SE3& b) { return -(a.inverse() * b).rotation().log().y(); }

TEST_P(ProfilesOnRecorded, YawFollowsTheReference) {
  const RecordedDrive& drive = GetParam();
  if (!recorded_data(drive.folder)) GTEST_SKIP() << no_recorded_data(drive.folder);
  const auto folder = recorded_data_path(drive.folder);
  const auto file = (folder / "poses.txt").string();
  const auto ground_truth = parse_kitti_poses(read_text_file(file), file);

  ProfilesOdometry odometry({}, drive.camera);
  std::vector<double> shifts, reference;
  double squares = 0.0, accumulated = 0.0;
  SE3 last;
  for (int i = 0; i < drive.frames; ++i) {
    const auto frame = read_frame(folder, i);
    ASSERT_TRUE(frame) << "frame " << i << " of " << folder;
    const auto update = odometry.process(*frame);
    ASSERT_TRUE(update.used) << i << ' ' << update.detail;
    ASSERT_NE(update.reason, OdometryReason::no_motion) << i;
    if (i > 0) {
      const auto before = static_cast<std::size_t>(i - 1);
      reference.push_back(yaw_between(ground_truth[before], ground_truth[before + 1]));
      const double yaw = yaw_between(last, update.world_from_camera);
      shifts.push_back(yaw * drive.camera.fx);
      squares += (yaw - reference.back()) * (yaw - reference.back());
      accumulated += yaw - reference.back();
    }
    last = update.world_from_camera;
  }
  constexpr double degrees = 180.0 / std::numbers::pi;
  const double rms = std::sqrt(squares / static_cast<double>(drive.frames - 1)) * degrees;
  const auto calibration = calibrate_yaw(shifts, reference);
  std::cout << drive.folder << ": yaw rms " << rms << " deg per frame, accumulated " << accumulated * degrees
            << " deg, lambda fx " << calibration.lambda * drive.camera.fx << '\n';
  EXPECT_LE(rms, drive.max_yaw_rms_deg);
  EXPECT_LE(std::abs(accumulated) * degrees, drive.max_yaw_end_deg);
  EXPECT_NEAR(calibration.lambda * drive.camera.fx, 1.0, drive.max_lambda_error);
}

TEST(ProfilesOnRecordedGround, ACameraOnTheGroundDoesNotMove) {
  const auto name = "euroc_v1_01_still_stereo/mav0/cam0/data";
  const auto folder = recorded_data(name);
  if (!folder) GTEST_SKIP() << no_recorded_data(name);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(*folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_GT(files.size(), 5U);
  const Camera camera{.width = 752,
                      .height = 480,
                      .fx = 458.654,
                      .fy = 457.296,
                      .cx = 367.215,
                      .cy = 248.375,
                      .distortion = Distortion::radial_tangential,
                      .coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0}};
  ProfilesOdometry odometry({}, camera);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto frame = read_image(files[i], static_cast<int>(i));
    ASSERT_TRUE(frame) << files[i];
    const auto update = odometry.process(*frame);
    EXPECT_EQ(update.reason, i > 0 ? OdometryReason::no_motion : OdometryReason::first_frame) << i;
    EXPECT_EQ(update.world_from_camera.translation().norm(), 0.0) << i;
  }
}

const Camera camera_of_00{.width = 1241, .height = 376, .fx = 718.856, .fy = 718.856, .cx = 607.1928, .cy = 185.2157};
const Camera camera_of_raw{.width = 1242, .height = 375, .fx = 721.5377, .fy = 721.5377, .cx = 609.5593, .cy = 172.854};

// The reference of the residential drive is itself accurate only to 0.2 degrees per frame.
INSTANTIATE_TEST_SUITE_P(Drives, ProfilesOnRecorded,
                         testing::Values(RecordedDrive{"kitti_00", 100, camera_of_00, 0.07, 2.0, 0.04},
                                         RecordedDrive{"kitti_residential", 100, camera_of_raw, 0.2, 4.0, 0.15}),
                         [](const auto& drive) { return std::string(drive.param.folder); });

}  // namespace
}  // namespace rastro
