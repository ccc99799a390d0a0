// SPDX-License-Identifier: Apache-2.0
// What the writers of KITTI recordings write, the readers read: the poses are the world's.
#include <gtest/gtest.h>

#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/dataset/open.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/worlds/street.h"
#include "rastro/synthetic/write_kitti.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr int frames = 60;  // Through the first turn.

const World& small_street() {
  static const World world = make_street({.scale = 0.05, .threads = 2});
  return world;
}

SE3 body_from_start(int frame) {
  const World& world = small_street();
  const SE3 camera_from_body = world.body_from_camera().inverse();
  return (world.world_from_camera(0) * camera_from_body).inverse() * world.world_from_camera(frame) * camera_from_body;
}

void expect_near(const SE3& is, const SE3& should, int frame) {
  EXPECT_LT((is.translation() - should.translation()).norm(), 1e-3) << "frame " << frame;
  EXPECT_LT((is.rotation().inverse() * should.rotation()).log().norm(), 1e-4) << "frame " << frame;
}

TEST(WriteKitti, raw_packets_are_read_back_as_the_way_driven) {
  const fs::path folder = scratch_path("raw");
  fs::remove_all(folder);
  TaskPool pool(2);
  const KittiSummary summary =
      write_kitti(small_street(), folder, {.frames = frames, .layout = KittiLayout::raw}, pool);
  const auto source = open(summary.recording.string());
  const SourceInfo& info = source->info();
  EXPECT_EQ(info.format, "kitti_raw");
  EXPECT_TRUE(info.warnings.empty()) << info.warnings.front();
  EXPECT_EQ(info.frame_count, frames);
  EXPECT_EQ(info.ground_truth_frame, "body");
  ASSERT_EQ(info.ground_truth.size(), static_cast<std::size_t>(frames));
  for (int frame = 0; frame < frames; ++frame) {
    expect_near(info.ground_truth[frame].world_from_body, body_from_start(frame), frame);
    EXPECT_EQ(info.ground_truth[frame].stamp, small_street().stamp(frame));
  }
  ASSERT_TRUE(info.cameras.at(0).body_from_camera);
  expect_near(*info.cameras[0].body_from_camera, small_street().body_from_camera(), 0);
  ASSERT_TRUE(info.cameras[0].camera);
  EXPECT_NEAR(info.cameras[0].camera->fx, small_street().camera().fx, 1e-6);
  EXPECT_EQ(source->next()->stamp, small_street().stamp(0));
  fs::remove_all(folder);
}

TEST(WriteKitti, odometry_is_read_back_as_the_camera_s_way) {
  const fs::path folder = scratch_path("odometry");
  fs::remove_all(folder);
  TaskPool pool(2);
  write_kitti(small_street(), folder, {.frames = frames}, pool);
  const auto source = open(folder.string());
  const SourceInfo& info = source->info();
  EXPECT_EQ(info.format, "kitti_odometry");
  EXPECT_TRUE(info.warnings.empty()) << info.warnings.front();
  ASSERT_EQ(info.ground_truth.size(), static_cast<std::size_t>(frames));
  const SE3 start_from_world = small_street().world_from_camera(0).inverse();
  for (int frame = 0; frame < frames; ++frame)
    expect_near(info.ground_truth[frame].world_from_body, start_from_world * small_street().world_from_camera(frame),
                frame);
  EXPECT_EQ(info.ground_truth[1].stamp, 100'000'000);
  // Read-back pictures are the rendered ones.
  const GreyImage rendered = small_street().render(0, pool).grey, read = source->next()->image;
  ASSERT_EQ(read.width(), rendered.width());
  for (int y = 0; y < read.height(); ++y)
    for (int x = 0; x < read.width(); ++x) ASSERT_EQ(read.at(x, y), rendered.at(x, y));
  EXPECT_THROW(write_kitti(small_street(), folder, {.frames = 1}, pool), Error);
  fs::remove_all(folder);
}

TEST(WriteKitti, a_lens_with_distortion_is_refused) {
  TaskPool pool(1);
  const World bent = make_hall({.scale = 0.05, .distortion = true});
  EXPECT_THROW(write_kitti(bent, scratch_path("bent"), {.frames = 1}, pool), Error);
}

}  // namespace
}  // namespace rastro
