// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/surface_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/backend/rgbd/keyframe_matcher.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/map/images/packed_depth.h"

namespace rastro {
namespace {

using testing::looking;
using testing::pose_near;
using testing::room_frame;
using testing::with_depth_noise;

SurfaceCheck room_check() { return {test_room::camera(), surface_options(RgbdSlamOptions())}; }

int all_of(const SurfaceAgreement& sum) { return sum.agree + sum.contradict + sum.hidden + sum.outside; }

/// A wall across the whole image.
DepthImage wall(double depth_m) {
  DepthImage depth(320, 240);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) depth.at(x, y) = static_cast<float>(depth_m);
  return depth;
}

/// The same with a board of 80 x 80 pixels in front of it.
DepthImage wall_with_board(double wall_m, double board_m) {
  DepthImage depth = wall(wall_m);
  for (int y = 80; y < 160; ++y)
    for (int x = 120; x < 200; ++x) depth.at(x, y) = static_cast<float>(board_m);
  return depth;
}

SE3 ahead(double meters) { return {SO3(), {0.0, 0.0, meters}}; }

TEST(SurfaceCheck, AViewAgreesWithItself) {
  const SurfaceCheck check = room_check();
  const KeyframeSurface surface = check.surface_of(room_frame(looking({-1.2, 0.0, 1.2}, 0.0)).depth);
  const SurfaceAgreement sum = check.compare(surface, surface, SE3());
  EXPECT_EQ(sum.contradict, 0);
  EXPECT_EQ(sum.hidden, 0);
  EXPECT_EQ(sum.evidence().observed_share(), 1.0);
  EXPECT_GT(sum.evidence().overlap(), 0.8) << "but for rims, of the image and of objects";
}

TEST(SurfaceCheck, TwoViewsOfTheRoomAgreeAtTheirTruePoses) {
  const SurfaceCheck check = room_check();
  for (const double noise_seed : {0.0, 1.0, 2.0}) {
    const SE3 a = looking({-1.2, -0.5, 1.2}, 0.2), b = looking({-1.0, 0.4, 1.4}, -0.1);
    Frame frame_a = room_frame(a), frame_b = room_frame(b);
    if (noise_seed > 0.0) {
      frame_a = with_depth_noise(frame_a, {}, static_cast<std::uint64_t>(noise_seed));
      frame_b = with_depth_noise(frame_b, {}, static_cast<std::uint64_t>(noise_seed) + 100);
    }
    const SurfaceAgreement sum =
        check.compare(check.surface_of(frame_a.depth), check.surface_of(frame_b.depth), a.inverse() * b);
    EXPECT_GT(sum.evidence().observed_share(), 0.98) << noise_seed;
    EXPECT_GT(sum.evidence().overlap(), 0.5) << noise_seed;
  }
}

TEST(SurfaceCheck, WrongPosesInTheRoomAreContradicted) {
  const SurfaceCheck check = room_check();
  const SE3 a = looking({-1.2, -0.5, 1.2}, 0.2), b = looking({-1.0, 0.4, 1.4}, -0.1);
  const KeyframeSurface of_a = check.surface_of(room_frame(a).depth), of_b = check.surface_of(room_frame(b).depth);
  for (const SE3& wrong : {SE3(SO3(), {0.0, 0.0, -0.4}), SE3(SO3(), {0.0, 0.0, 0.4}), SE3(SO3(), {0.0, 0.4, 0.0}),
                           SE3(SO3::exp({0.0, 0.3, 0.0}), Eigen::Vector3d::Zero()),
                           SE3(SO3::exp({0.25, 0.0, 0.0}), Eigen::Vector3d::Zero())}) {
    EXPECT_LT(check.compare(of_a, of_b, a.inverse() * b * wrong).evidence().observed_share(), 0.9)
        << wrong.log().transpose();
  }
}

/// A surface may be nearer by up to three standard deviations of both depths and one hundredth: 7.4 cm at 2 m.
TEST(SurfaceCheck, ASurfaceInFrontOfTheMeasuredOneByMoreThanTheNoiseIsAContradiction) {
  const SurfaceCheck check = room_check();
  const KeyframeSurface two_meters = check.surface_of(wall(2.0));
  const RgbdSlamOptions options;
  const double sigma = options.follow.depth_sigma_m + options.follow.depth_sigma_per_m2 * 4.0;
  const double allowed = 3.0 * (sigma + sigma) + 0.01 * 2.0;
  ASSERT_NEAR(allowed, 0.074, 1e-9);
  for (const double side : {-1.0, 1.0}) {
    const SurfaceAgreement within = check.compare(two_meters, two_meters, ahead(side * 0.9 * allowed));
    EXPECT_EQ(within.contradict, 0) << side;
    EXPECT_GT(within.agree, 0) << side;
    const SurfaceAgreement beyond = check.compare(two_meters, two_meters, ahead(side * 1.15 * allowed));
    EXPECT_EQ(beyond.agree, 0) << side;
    EXPECT_GT(beyond.contradict, 0) << side << ": one of the two sees through the other's wall";
    EXPECT_GT(beyond.hidden, 0) << side << ": and is occluded behind it in the opposite direction";
    EXPECT_EQ(beyond.evidence().observed_share(), 0.0);
  }
}

/// A wall at 3 m; one of the two views has a board at 2 m in front of it. The other view looks through it: a
/// contradiction. The wall occluded by the board is no evidence.
TEST(SurfaceCheck, ABoardThatTheOtherLooksThroughIsAContradictionAndTheWallBehindItIsOccluded) {
  const SurfaceCheck check = room_check();
  const KeyframeSurface bare = check.surface_of(wall(3.0)), board = check.surface_of(wall_with_board(3.0, 2.0));
  const SurfaceAgreement sum = check.compare(bare, board, SE3());
  // 20 x 20 blocks of board, every other one of every other row.
  EXPECT_GE(sum.contradict, 9 * 9);
  EXPECT_LE(sum.contradict, 10 * 10);
  EXPECT_GE(sum.hidden, 8 * 8);
  EXPECT_LE(sum.hidden, 10 * 10);
  EXPECT_GT(sum.agree, 5 * sum.contradict);
  const SurfaceAgreement swapped = check.compare(board, bare, SE3());
  EXPECT_EQ(swapped.contradict, sum.contradict) << "it counts in both directions";
  EXPECT_EQ(swapped.hidden, sum.hidden);
  EXPECT_EQ(swapped.agree, sum.agree);
}

/// From the side more of the surface behind the box is visible: correct poses are accepted.
TEST(SurfaceCheck, SurfacesOccludedByABoxInOneOfTwoViewsAreNoContradiction) {
  const SurfaceCheck check = room_check();
  const SE3 a = looking({-0.6, -1.1, 0.5}, 0.3, -0.1), b = looking({-0.6, 1.2, 0.5}, -0.25, -0.1);
  const SurfaceAgreement sum =
      check.compare(check.surface_of(room_frame(a).depth), check.surface_of(room_frame(b).depth), a.inverse() * b);
  EXPECT_GT(sum.hidden, 50) << "each sees floor and wall that the box hides from the other";
  EXPECT_GT(sum.evidence().observed_share(), 0.97);
}

TEST(SurfaceCheck, WithoutDepthThereIsNothingToJudge) {
  const SurfaceCheck check = room_check();
  const KeyframeSurface some = check.surface_of(wall(2.0)), blank = check.surface_of(DepthImage(320, 240)),
                        other_size = check.surface_of(DepthImage(160, 120));
  EXPECT_TRUE(other_size.blocks.empty()) << "of another camera";
  for (const KeyframeSurface* none : {&blank, &other_size}) {
    for (const SurfaceAgreement& sum : {check.compare(some, *none, SE3()), check.compare(*none, some, SE3())}) {
      EXPECT_EQ(sum.agree + sum.contradict + sum.hidden, 0);
      EXPECT_EQ(sum.evidence().observed_share(), 0.0);
      EXPECT_EQ(sum.evidence().overlap(), 0.0);
    }
    EXPECT_EQ(check.fit(some, *none, SE3(), 0.1).compared, 0);
  }
}

TEST(SurfaceCheck, EveryMeasurementIsCountedOnce) {
  const SurfaceCheck check = room_check();
  const KeyframeSurface surface = check.surface_of(wall(2.0));
  // Every other of 80 x 60 blocks in both directions, of both views, wherever they project.
  for (const SE3& wrong : {SE3(), ahead(0.5), ahead(-0.5), SE3(SO3(), {1.0, 0.0, 0.0}),
                           SE3(SO3::exp({0.0, M_PI, 0.0}), Eigen::Vector3d::Zero())}) {
    EXPECT_EQ(all_of(check.compare(surface, surface, wrong)), 2 * 40 * 30) << wrong.log().transpose();
  }
  const SurfaceAgreement behind =
      check.compare(surface, surface, SE3(SO3::exp({0.0, M_PI, 0.0}), Eigen::Vector3d::Zero()));
  EXPECT_EQ(behind.outside, 2 * 40 * 30) << "back to back they see nothing of each other";
}

TEST(SurfaceCheck, ASurfaceIsTheSameFromAFrameAsFromItsPackedImages) {
  const SurfaceCheck check = room_check();
  const Frame frame = with_depth_noise(room_frame(looking({-1.2, 0.2, 1.2}, 0.1)), {}, 5);
  const KeyframeSurface from_frame = check.surface_of(frame.depth),
                        from_file = check.surface_of(unpack_images(pack_images(frame), "test").depth);
  EXPECT_EQ(from_frame.blocks.depth, from_file.blocks.depth);
  ASSERT_EQ(from_frame.planes.size(), from_file.planes.size());
  for (std::size_t k = 0; k < from_frame.planes.size(); ++k) {
    EXPECT_EQ(from_frame.planes[k].normal, from_file.planes[k].normal);
    EXPECT_EQ(from_frame.planes[k].distance, from_file.planes[k].distance);
  }
}

/// 65535 units of 0.2 mm.
TEST(SurfaceCheck, TheFarthestDepthIsThatOfPackedImages) {
  RgbdSlamOptions settings;
  SurfaceOptions options = surface_options(settings);
  options.max_depth_m = 20.0;
  const SurfaceCheck check(test_room::camera(), options);
  for (const int units : {65534, 65535, 65536}) {
    const DepthImage depth = wall(units / packed_depth_units_per_meter);
    const DepthBlocks blocks = check.surface_of(depth).blocks;
    EXPECT_NEAR(blocks.depth.at(40), units <= 65535 ? units / packed_depth_units_per_meter : 0.0, 1e-4) << units;
    Frame frame;
    frame.image = GrayImage(depth.width(), depth.height());
    frame.depth = depth;
    const DepthImage unpacked = unpack_images(pack_images(frame), "test").depth;
    EXPECT_NEAR(blocks.depth.at(40), unpacked.at(160, 2), 1e-4F) << units;
  }
}

TEST(SurfaceCheck, SurfacesAreAligned) {
  const SurfaceCheck check = room_check();
  const SE3 a = looking({-1.2, -0.3, 1.2}, 0.2), b = looking({-1.1, 0.1, 1.3}, 0.05), a_from_b = a.inverse() * b;
  const KeyframeSurface of_a = check.surface_of(room_frame(a).depth), of_b = check.surface_of(room_frame(b).depth);
  SE3 slid = a_from_b * SE3::exp((Vector6d() << 0.04, -0.03, 0.05, 0.02, -0.015, 0.02).finished());
  for (int k = 0; k < 10; ++k) {
    const SurfaceFit fit = check.fit(of_a, of_b, slid, 0.2);
    ASSERT_GT(fit.compared, 100);
    slid = slid * SE3::exp(fit.information.ldlt().solve(fit.gradient));
  }
  EXPECT_THAT(slid, pose_near(a_from_b, 0.003, 0.002));
}

TEST(SurfaceAgreement, ShareAndOverlapHaveTheirDefinitions) {
  EXPECT_EQ((SurfaceAgreement{30, 10, 40, 20}.evidence().observed_share()), 0.75);
  EXPECT_EQ((SurfaceAgreement{30, 10, 40, 20}.evidence().overlap()), 0.4);
  EXPECT_EQ(SurfaceAgreement().evidence().observed_share(), 0.0);
  EXPECT_EQ((SurfaceAgreement{0, 5, 0, 0}.evidence().overlap()), 0.0);
}

}  // namespace
}  // namespace rastro
