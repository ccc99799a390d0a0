// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/hall.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/synthetic/write_euroc.h"

namespace rastro {
namespace {

/// A quarter of the size: the occlusions are the same, and it is made quickly.
const World& small_hall() {
  static const World world = make_hall({.scale = 0.25, .threads = 2});
  return world;
}

/// Frames in which each point of frame 0's upper half is occluded or outside, and number of occluded points per frame.
struct Occlusion {
  std::vector<double> occluded_share;
  std::vector<int> occluded_frames;
};

Occlusion occlusion_of_upper_half(const World& world, int frames) {
  std::vector<Eigen::Vector3d> points;
  for (int y = 2; y < world.camera().height / 2; y += 5)
    for (int x = 2; x < world.camera().width; x += 5)
      if (const auto hit = world.surface_at(0, {x, y})) points.push_back(hit->point);
  Occlusion result;
  result.occluded_frames.assign(points.size(), 0);
  for (int frame = 0; frame < frames; ++frame) {
    int hidden = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const PointView view = world.view_of(frame, points[i]);
      const bool is_occluded = view.inside && !view.visible;
      hidden += is_occluded ? 1 : 0;
      result.occluded_frames[i] += is_occluded ? 1 : 0;
    }
    result.occluded_share.push_back(static_cast<double>(hidden) / static_cast<double>(points.size()));
  }
  return result;
}

TEST(HallTest, most_of_the_upper_half_is_occluded_for_8_to_15_of_the_first_30_frames_and_reappears) {
  const Occlusion occlusion = occlusion_of_upper_half(small_hall(), 31);
  int mostly_occluded = 0;
  for (std::size_t frame = 0; frame < occlusion.occluded_share.size(); ++frame) {
    std::printf("frame %2zu: %5.1f %% of the upper half occluded\n", frame, 100.0 * occlusion.occluded_share[frame]);
    mostly_occluded += frame < 30 && occlusion.occluded_share[frame] > 0.5 ? 1 : 0;
  }
  EXPECT_GE(mostly_occluded, 8);
  EXPECT_LE(mostly_occluded, 15);
  EXPECT_GT(occlusion.occluded_share[17], 0.9);
  EXPECT_LT(occlusion.occluded_share[2], 0.05);
  for (std::size_t frame = 28; frame <= 30; ++frame) EXPECT_LT(occlusion.occluded_share[frame], 0.1);
  int as_asked = 0;
  for (const int frames : occlusion.occluded_frames) as_asked += frames >= 8 && frames <= 15 ? 1 : 0;
  EXPECT_GT(as_asked, static_cast<int>(occlusion.occluded_frames.size()) / 2);
}

TEST(HallTest, the_drone_returns_near_its_start) {
  const SE3 moved = small_hall().world_from_camera(0).inverse() * small_hall().world_from_camera(29);
  EXPECT_LT(moved.translation().norm(), 0.12);
  EXPECT_GT(moved.translation().norm(), 0.01) << "near, not exactly at";
  EXPECT_LT(moved.rotation().log().norm(), 0.06);
}

TEST(HallTest, an_abrupt_rotation_and_back) {
  const World& world = small_hall();
  const double rotation = (world.world_from_camera(42).inverse() * world.world_from_camera(47)).rotation().log().norm();
  EXPECT_GT(rotation, 0.44);
  EXPECT_LT(rotation, 0.61);
  EXPECT_LT((world.world_from_camera(41).inverse() * world.world_from_camera(57)).rotation().log().norm(), 0.08);
}

TEST(HallTest, the_pillar_occludes_points_for_6_to_12_frames) {
  const World& world = small_hall();
  // Far points left and right of the image center that only the pillar passes.
  int as_asked = 0, hidden = 0;
  for (int x = 40; x < 150; x += 10) {
    const auto hit = world.surface_at(93, {x, 45});
    if (!hit || (hit->point - world.world_from_camera(93).translation()).norm() < 3.0) continue;
    int frames = 0;
    for (int frame = 74; frame <= 114; ++frame) {
      const PointView view = world.view_of(frame, hit->point);
      frames += view.inside && !view.visible ? 1 : 0;
    }
    if (frames == 0) continue;
    ++hidden;
    as_asked += frames >= 6 && frames <= 14 ? 1 : 0;
  }
  EXPECT_GE(hidden, 3);
  EXPECT_GE(as_asked * 2, hidden);
}

TEST(HallTest, the_flight_is_smooth_and_never_inside_anything) {
  const World& world = small_hall();
  for (int frame = 0; frame < 10000; frame += frame < 200 ? 1 : 7) {
    const SE3 here = world.world_from_camera(frame), next = world.world_from_camera(frame + 1);
    ASSERT_FALSE(world.scene().touches(here.translation(), 0.25)) << "frame " << frame;
    const SE3 step = here.inverse() * next;
    ASSERT_LT(step.translation().norm(), 0.09) << "frame " << frame;
    ASSERT_GT(step.translation().norm() + step.rotation().log().norm(), 1e-4) << "it is at rest at frame " << frame;
    ASSERT_LT(step.rotation().log().norm(), frame > 60 ? 0.03 : 0.2) << "frame " << frame;
  }
}

TEST(HallTest, frames_are_the_same_for_any_threads_and_differ_for_another_seed) {
  const World again = make_hall({.scale = 0.25, .threads = 1}),
              other = make_hall({.seed = 2, .scale = 0.25, .threads = 2});
  TaskPool one(1), eight(8);
  const RenderedFrame a = small_hall().render(12, eight), b = again.render(12, one), c = other.render(12, one);
  std::int64_t differ = 0;
  for (int y = 0; y < a.gray.height(); ++y) {
    ASSERT_EQ(0, std::memcmp(a.gray.row(y), b.gray.row(y), static_cast<std::size_t>(a.gray.width())));
    for (int x = 0; x < a.gray.width(); ++x) differ += std::abs(a.gray.at(x, y) - c.gray.at(x, y)) > 10 ? 1 : 0;
  }
  EXPECT_GT(differ, a.gray.width() * a.gray.height() / 4);
}

TEST(HallTest, images_have_contrast_and_are_neither_black_nor_overexposed) {
  TaskPool pool(2);
  for (const int frame : {0, 17, 94, 700}) {
    const RenderedFrame shot = small_hall().render(frame, pool);
    double sum = 0, squares = 0, extreme = 0;
    const double pixels = shot.gray.width() * shot.gray.height();
    for (int y = 0; y < shot.gray.height(); ++y)
      for (int x = 0; x < shot.gray.width(); ++x) {
        const double value = shot.gray.at(x, y);
        sum += value, squares += value * value, extreme += value <= 2 || value >= 253 ? 1 : 0;
      }
    const double mean = sum / pixels;
    EXPECT_GT(mean, 70) << "frame " << frame;
    EXPECT_LT(mean, 180) << "frame " << frame;
    EXPECT_GT(std::sqrt(squares / pixels - mean * mean), 25) << "frame " << frame;
    EXPECT_LT(extreme / pixels, 0.08) << "frame " << frame;
  }
}

TEST(HallTest, the_source_gives_frames_with_ground_truth) {
  const std::unique_ptr<Source> source = synthetic_source(small_hall(), 2);
  ASSERT_EQ(source->info().ground_truth.size(), 2U);
  ASSERT_TRUE(source->info().cameras.at(0).camera);
  const auto first = source->next(), second = source->next();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->stamp - first->stamp, 50'000'000);
  EXPECT_EQ(second->index, 1);
  EXPECT_EQ(first->image.width(), 188);
  EXPECT_FALSE(source->next());
}

TEST(HallTest, a_folder_that_is_not_empty_is_refused) {
  namespace fs = std::filesystem;
  const fs::path folder = scratch_path("refused");
  TaskPool pool(2);
  const EurocSummary summary = write_euroc(small_hall(), folder, {.frames = 2, .ground_truth = false}, pool);
  EXPECT_EQ(summary.frames, 2);
  EXPECT_TRUE(fs::exists(folder / "mav0/cam0/sensor.yaml"));
  EXPECT_FALSE(fs::exists(folder / "mav0/truth"));
  EXPECT_THROW(write_euroc(small_hall(), folder, {.frames = 2}, pool), Error);
  EXPECT_NO_THROW(write_euroc(small_hall(), folder, {.frames = 2, .ground_truth = false, .force = true}, pool));
  fs::remove_all(folder);
  EXPECT_THROW(make_hall({.scale = 100}), Error);
}

}  // namespace
}  // namespace rastro
