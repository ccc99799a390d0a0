// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/stereo_slam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/base/error.h"
#include "rastro/slam/rtabmap/method.h"

namespace rastro {
namespace {

using testing::looking;
using testing::pose_near;

constexpr double baseline = 0.12;

/// Along a wall of the test room, about 2 m in front of it.
SE3 left_at(int k) { return looking({-0.5 + 0.01 * k, -0.2 + 0.02 * k, 1.2}, 0.02 * k, -0.3); }

Frame stereo_frame(int k) {
  Frame frame = testing::room_frame(left_at(k), k);
  frame.right = test_room::frame_from(left_at(k) * SE3(SO3(), {baseline, 0.0, 0.0})).image;
  frame.depth = {};
  return frame;
}

SourceInfo stereo_source() {
  SourceInfo source;
  source.path = "room";
  source.has_right = true;
  source.cameras.resize(2);
  for (CalibratedCamera& each : source.cameras) each.camera = test_room::camera();
  source.left_from_right = SE3(SO3(), {baseline, 0.0, 0.0});
  return source;
}

TEST(StereoSlam, PosesAreRightToACentimeter) {
  const auto slam = rtabmap_slam_method()->make(stereo_source(), {});
  constexpr int frames = 15;
  for (int k = 0; k < frames; ++k) {
    const SlamUpdate update = slam->process(stereo_frame(k));
    EXPECT_EQ(update.state, SlamState::tracking) << k << ' ' << update.detail;
    EXPECT_THAT(update.world_from_body, pose_near(left_at(0).inverse() * left_at(k), 0.01, 0.005)) << k;
    EXPECT_EQ(update.times.front().stage, "stereo");
  }
  slam->finish();
  EXPECT_EQ(slam->trajectory().size(), static_cast<std::size_t>(frames));
  const auto map = slam->snapshot();
  EXPECT_GE(map->keyframes.size(), 2U);
  ASSERT_EQ(map->cameras.size(), 1U);
  EXPECT_EQ(map->cameras[0].kind, CameraKind::stereo);
  EXPECT_GT(map->cameras[0].baseline, 0.0);
  EXPECT_EQ(map->sessions[0].scale.origin, "stereo baseline");
}

TEST(StereoSlam, AFrameWithoutItsRightImageIsNotFollowed) {
  const auto slam = rtabmap_slam_method()->make(stereo_source(), {});
  slam->process(stereo_frame(0));
  Frame half = stereo_frame(1);
  half.right = {};
  slam->process(half);
  const SlamUpdate update = slam->process(stereo_frame(2));
  EXPECT_EQ(update.state, SlamState::tracking);
  EXPECT_THAT(update.world_from_body, pose_near(left_at(0).inverse() * left_at(2), 0.01, 0.005));
}

/// The map says what noise of the depth is assumed.
TEST(StereoSlam, SettingsThatFollowFromThePairStayAsTheyWereSet) {
  const auto noise_with = [](const char* name, const char* value) {
    const auto method = rtabmap_slam_method();
    OptionTable table = method->options();
    if (*name != '\0') table.set(name, value, "a test");
    return method->make(stereo_source(), {})->snapshot()->cameras.at(0).depth_noise;
  };
  const DepthNoise usual = noise_with("", "");
  EXPECT_EQ(usual.sigma_m, 0.0);
  const DepthNoise set = noise_with("depth_sigma_m", "0.05");
  EXPECT_EQ(set.sigma_m, 0.05);
  EXPECT_EQ(set.sigma_per_m2, usual.sigma_per_m2) << "the others follow";
}

/// What a source of `change` is refused with.
std::string refusal(const std::function<void(SourceInfo&, OptionTable&)>& change) {
  const auto method = rtabmap_slam_method();
  SourceInfo source = stereo_source();
  OptionTable table = method->options();
  change(source, table);
  try {
    method->make(source, {});
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(StereoSlam, ASourceWithoutWhatItNeedsIsRefused) {
  using ::testing::HasSubstr;
  EXPECT_EQ(refusal([](auto&, auto&) {}), "");
  EXPECT_THAT(refusal([](auto& source, auto&) { source.cameras.clear(); }), HasSubstr("no calibration"));
  EXPECT_THAT(refusal([](auto& source, auto&) { source.has_right = false; }), HasSubstr("no depth images"));
  EXPECT_THAT(refusal([](auto& source, auto&) { source.cameras.pop_back(); }), HasSubstr("calibration of both"));
  EXPECT_THAT(refusal([](auto& source, auto&) {
                source.left_from_right = SE3(SO3(), {0.0, 0.0, 0.12});
              }),
              HasSubstr("not side by side"));
  EXPECT_THAT(refusal([](auto&, auto& table) { table.set("sensor", "rgbd", "a test"); }), HasSubstr("no depth images"));
  EXPECT_THAT(refusal([](auto& source, auto& table) {
                table.set("sensor", "stereo", "a test");
                source.has_right = false;
                source.has_depth = true;
              }),
              HasSubstr("no right images"));
}

}  // namespace
}  // namespace rastro
