// SPDX-License-Identifier: Apache-2.0
// What the writers of recordings write, the readers read: the poses are the world's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <initializer_list>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/command.h"
#include "rastro/dataset/open.h"
#include "rastro/evaluate/length_objects.h"
#include "rastro/export/ply.h"
#include "rastro/synthetic/worlds/corridor.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/worlds/loop.h"
#include "rastro/synthetic/worlds/rooms.h"
#include "rastro/synthetic/worlds/street.h"
#include "rastro/synthetic/write_euroc.h"
#include "rastro/synthetic/write_kitti.h"
#include "rastro/synthetic/write_laser_log.h"
#include "rastro/synthetic/write_objects.h"
#include "rastro/synthetic/write_tum.h"

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

TEST(WriteKitti, odometry_is_read_back_as_the_camera_s_trajectory) {
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
  // Read-back images are the rendered ones.
  const GrayImage rendered = small_street().render(0, pool).gray, read = source->next()->image;
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

TEST(WriteStereo, both_cameras_are_read_back_where_they_are) {
  TaskPool pool(2);
  const World world = make_loop({.scale = 0.1, .threads = 2});
  const fs::path euroc = scratch_path("euroc_stereo"), kitti = scratch_path("kitti_stereo");
  fs::remove_all(euroc);
  fs::remove_all(kitti);
  write_euroc(world, euroc, {.frames = 2, .ground_truth = false, .stereo = true}, pool);
  write_kitti(world, kitti, {.frames = 2, .stereo = true}, pool);
  const GrayImage right = world.render_right(1, pool).gray;
  OpenOptions both;
  both.want_right = true;
  for (const fs::path& folder : {euroc, kitti}) {
    SCOPED_TRACE(folder.string());
    const auto source = open(folder.string(), both);
    EXPECT_TRUE(source->info().warnings.empty()) << source->info().warnings.front();
    EXPECT_TRUE(source->info().has_right);
    ASSERT_TRUE(source->info().left_from_right);
    expect_near(*source->info().left_from_right, *world.left_from_right(), 0);
    source->next();
    const auto frame = source->next();
    ASSERT_TRUE(frame && frame->right.width() == right.width());
    for (int y = 0; y < right.height(); ++y)
      for (int x = 0; x < right.width(); ++x) ASSERT_EQ(frame->right.at(x, y), right.at(x, y));
    fs::remove_all(folder);
  }
  EXPECT_THROW(write_euroc(small_street(), euroc, {.frames = 1, .stereo = true}, pool), Error);
  EXPECT_THROW(write_kitti(world, kitti, {.frames = 1, .layout = KittiLayout::raw, .stereo = true}, pool), Error);
}

TEST(WriteLaserLog, a_folder_is_read_back_as_scans_with_odometry_and_truth) {
  const fs::path folder = scratch_path("laser");
  TaskPool pool(2);
  const LaserWorld world = make_corridor_floor();
  write_laser_log(world, folder, {.scans = 40}, pool);
  const auto source = open(folder.string());
  const SourceInfo& info = source->info();
  EXPECT_EQ(info.format, "carmen");
  EXPECT_TRUE(info.warnings.empty()) << info.warnings.front();
  EXPECT_TRUE(info.has_scan && info.has_odometry && !info.has_image);
  EXPECT_EQ(info.ground_truth.size(), 40U);
  EXPECT_EQ(info.ground_truth_frame, "body");
  const auto landmarks = open((folder / "landmarks.txt").string());
  auto sighted = landmarks->next();
  for (std::int64_t scan = 0; scan < 40; ++scan) {
    const auto frame = source->next();
    ASSERT_TRUE(frame && frame->scan && frame->odometry_from_body);
    EXPECT_EQ(frame->stamp, world.stamp(scan));
    EXPECT_LT((world.laser.body_from_laser.inverse() * frame->scan->body_from_laser).log().norm(), 1e-9);
    const SE2 laser = world.world_from_body(world.time_of(scan)) * world.laser.body_from_laser;
    int compared = 0;
    for (std::size_t beam = 0; beam < frame->scan->ranges.size(); ++beam) {
      const LaserHit hit = trace_level(world.scene->at(world.time_of(scan)), world.panes, laser.translation(),
                                       world.laser.height_m, laser.rotation().angle() + frame->scan->angle_of(beam));
      if (!frame->scan->is_return(beam) || hit.glass_range) continue;
      ASSERT_NEAR(hit.range, static_cast<double>(frame->scan->ranges[beam]), 0.06) << scan << ' ' << beam;
      ++compared;
    }
    EXPECT_GT(compared, 400);
    if (!sighted || sighted->stamp != frame->stamp) continue;
    ASSERT_TRUE(sighted->odometry_from_body);
    EXPECT_LT((sighted->odometry_from_body->inverse() * *frame->odometry_from_body).log().norm(), 1e-3);
    EXPECT_EQ(sighted->landmarks.size(), sight_landmarks(world, scan).size());
    sighted = landmarks->next();
  }
  EXPECT_FALSE(source->next() || sighted) << "nothing is left";
}

/// A file in each of the folders.
void litter(const fs::path& folder, std::initializer_list<const char*> parts) {
  for (const char* part : parts) {
    fs::create_directories(folder / part);
    write_whole_file(folder / part / "former.png", "x");
  }
}

TEST(WriteWithForce, a_former_recording_leaves_nothing_in_the_new_one) {
  TaskPool pool(2);
  const World& world = small_street();
  const fs::path euroc = scratch_path("forced_euroc"), tum = scratch_path("forced_tum"),
                 kitti = scratch_path("forced_kitti"), raw = scratch_path("forced_raw");
  const fs::path drive = write_kitti(world, raw, {.frames = 1, .layout = KittiLayout::raw}, pool).recording;
  litter(euroc, {"mav0/cam0/data", "mav0/cam1/data", "mav0/truth/depth", "closures.yaml", "mav0/imu0"});
  litter(tum, {"rgb", "depth", "objects.yaml", "truth.ply", "notes"});
  litter(kitti, {"image_0", "image_1", "velodyne"});
  litter(drive, {"image_00/data", "oxts/data", "velodyne_points"});
  write_euroc(world, euroc, {.frames = 1, .ground_truth = false, .force = true}, pool);
  write_tum(world, tum, {.frames = 1, .force = true}, pool);
  write_kitti(world, kitti, {.frames = 1, .force = true}, pool);
  write_kitti(world, raw, {.frames = 1, .layout = KittiLayout::raw, .force = true}, pool);
  for (const fs::path& gone : {euroc / "mav0/cam1", euroc / "mav0/truth", euroc / "closures.yaml",
                               euroc / "mav0/cam0/data/former.png", tum / "rgb/former.png", tum / "depth/former.png",
                               tum / "objects.yaml", tum / "truth.ply", kitti / "image_0/former.png", kitti / "image_1",
                               drive / "image_00/data/former.png", drive / "oxts/data/former.png"})
    EXPECT_FALSE(fs::exists(gone)) << gone;
  for (const fs::path& stays :
       {euroc / "mav0/imu0/former.png", tum / "notes/former.png", kitti / "velodyne/former.png",
        drive / "velodyne_points/former.png", euroc / "mav0/cam0/data.csv", tum / "rgb.txt", kitti / "poses.txt"})
    EXPECT_TRUE(fs::exists(stays)) << stays;
}

TEST(WriteWithForce, nothing_outside_of_the_folder_is_removed) {
  TaskPool pool(2);
  const fs::path folder = scratch_folder("forced"), elsewhere = scratch_folder("elsewhere");
  litter(elsewhere, {"cam0", "rgb"});
  fs::create_directory_symlink(elsewhere, folder / "mav0");
  fs::create_directory_symlink(elsewhere / "rgb", folder / "rgb");
  write_euroc(small_street(), folder, {.frames = 1, .ground_truth = false, .force = true}, pool);
  write_tum(small_street(), folder, {.frames = 1, .force = true}, pool);
  EXPECT_TRUE(fs::exists(elsewhere / "cam0/former.png"));
  EXPECT_TRUE(fs::exists(elsewhere / "rgb/former.png"));
  EXPECT_FALSE(fs::is_symlink(folder / "rgb"));
}

/// What `rastro simulate corridor` says to these words.
std::string refusal_of_corridor(std::vector<std::string> words) {
  words.insert(words.begin(), {"simulate", "corridor", "--quiet", "--out", scratch_path("refused").string()});
  CLI::App app;
  cli::Context context;
  cli::add_simulate_command(app, context);
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SimulateCorridor, parts_are_refused_for_the_laser_alone) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal_of_corridor({"--frames", "1", "--every", "5"}), HasSubstr("--every: a laser log has every scan"));
  EXPECT_THAT(refusal_of_corridor({"--frames", "1", "--first", "5"}), HasSubstr("--first: a laser log has every scan"));
  EXPECT_THAT(refusal_of_corridor({"--format", "carmen", "--every", "5"}), HasSubstr("a laser log has every scan"));
  EXPECT_THAT(refusal_of_corridor({"--format", "tum", "--first", "5", "--every", "2", "--threads=-1"}),
              HasSubstr("threads is negative"));
}

TEST(WriteTum, depth_and_poses_are_read_back) {
  const fs::path folder = scratch_path("rgbd");
  TaskPool pool(2);
  const World world = make_corridor({.scale = 0.1, .threads = 2});
  write_tum(world, folder, {.frames = 3}, pool);
  OpenOptions options;
  options.want_depth = true;
  const auto source = open(folder.string(), options);
  EXPECT_EQ(source->info().format, "tum_rgbd");
  EXPECT_TRUE(source->info().warnings.empty()) << source->info().warnings.front();
  EXPECT_EQ(source->info().depth_factor, 5000.0);
  EXPECT_NEAR(source->info().cameras.at(0).camera->fx, world.camera().fx, 1e-9);
  for (int frame = 0; frame < 3; ++frame) {
    const auto read = source->next();
    ASSERT_TRUE(read && !read->depth.empty());
    EXPECT_EQ(read->stamp, world.stamp(frame));
    EXPECT_EQ(read->depth_stamp, read->stamp);
    expect_near(source->info().ground_truth.at(static_cast<std::size_t>(frame)).world_from_body,
                world.world_from_camera(frame), frame);
    const RenderedFrame shot = world.render(frame, pool);
    for (int y = 0; y < shot.depth.height(); ++y)
      for (int x = 0; x < shot.depth.width(); ++x) {
        ASSERT_EQ(read->image.at(x, y), shot.gray.at(x, y));
        const double should = static_cast<double>(shot.depth.at(x, y)), is = static_cast<double>(read->depth.at(x, y));
        if (should < 0.4 || should > 8.0) {
          ASSERT_EQ(is, 0.0) << x << ' ' << y;
        } else {
          ASSERT_NEAR(is, should, 6.0 * (0.0012 + 0.0019 * should * should)) << x << ' ' << y;
        }
      }
  }
}

TEST(WriteTum, a_room_is_read_back_in_color_with_depth_at_times_of_its_own) {
  const fs::path folder = scratch_path("room");
  TaskPool pool(2);
  const World world = make_bedroom({.scale = 0.125, .threads = 2});
  write_tum(world, folder, {.frames = 4, .black = std::pair(0.09, 0.2)}, pool);
  OpenOptions options;
  options.want_depth = options.want_color = true;
  const auto source = open(folder.string(), options);
  EXPECT_TRUE(source->info().warnings.empty()) << source->info().warnings.front();
  for (int frame = 0; frame < 4; ++frame) {
    const auto read = source->next();
    ASSERT_TRUE(read && !read->depth.empty() && !read->color.empty());
    EXPECT_EQ(read->stamp, world.stamp(frame));
    EXPECT_EQ(read->depth_stamp - read->stamp, 12'000'000);
    const RenderedFrame shot = world.render(frame, pool), later = world.depth_at(world.time_of(frame) + 0.012, pool);
    int measured = 0;
    for (int y = 0; y < shot.depth.height(); ++y)
      for (int x = 0; x < shot.depth.width(); ++x) {
        const bool black = frame == 3;
        for (int channel = 0; channel < 3; ++channel)
          ASSERT_EQ(read->color.rgb.at(3 * x + channel, y), black ? 0 : shot.color.rgb.at(3 * x + channel, y));
        const float is = read->depth.at(x, y), should = later.depth.at(x, y);
        measured += is > 0.0F && std::abs(is - should) < 0.06F * should ? 1 : 0;
      }
    const int pixels = shot.depth.width() * shot.depth.height();
    EXPECT_TRUE(frame == 3 ? measured == 0 : measured > pixels * 7 / 10) << frame << ' ' << measured;
  }
  const TriangleMesh ground_truth = read_mesh_ply((folder / "truth.ply").string());
  EXPECT_GT(ground_truth.triangles.size(), 1000U);
  for (const MeshVertex& vertex : ground_truth.vertices) {
    const Eigen::Vector3d position = world.world_from_camera(0) * vertex.position.cast<double>();
    ASSERT_TRUE(world.scene().touches(position, 1e-3)) << position.transpose();
  }
  EXPECT_TRUE(fs::exists(folder / "objects.yaml"));
}

/// A map has the frame of the recording's first camera, which need not be the first one of the world.
TEST(WriteTum, lengths_and_surfaces_are_in_the_frame_of_the_first_camera_of_the_recording) {
  constexpr std::int64_t first = 300;
  const fs::path folder = scratch_path("later");
  TaskPool pool(2);
  const World world = make_bedroom({.scale = 0.125, .threads = 2});
  write_tum(world, folder, {.frames = 1, .selection = {.first = first}}, pool);
  const SE3 world_from_map = world.world_from_camera(first);
  const Scene scene = world.scene_at(first);
  for (const MeshVertex& vertex : read_mesh_ply((folder / "truth.ply").string()).vertices) {
    const Eigen::Vector3d position = world_from_map * vertex.position.cast<double>();
    ASSERT_TRUE(scene.touches(position, 1e-3)) << position.transpose();
  }
  const LengthObjects read = parse_length_objects(read_whole_file(folder / "objects.yaml"), "objects.yaml");
  ASSERT_EQ(read.objects.size(), world.lengths().size());
  for (std::size_t i = 0; i < read.objects.size(); ++i)
    EXPECT_LT((world_from_map * read.objects[i].a.point - world.lengths()[i].a.middle).norm(), 0.0174) << i;
}

TEST(WriteTum, what_can_be_measured_is_read_back_as_precisely_as_it_was_pointed_at) {
  const World world = make_study({.scale = 0.05, .threads = 2});
  const SE3 world_from_map = world.world_from_camera(0);
  const LengthObjects read = parse_length_objects(objects_text(world), "objects.yaml");
  ASSERT_EQ(read.objects.size(), world.lengths().size());
  for (std::size_t i = 0; i < read.objects.size(); ++i) {
    const LengthObject& is = read.objects[i];
    const NamedLength& should = world.lengths()[i];
    EXPECT_EQ(is.name, should.name);
    EXPECT_EQ(is.kind, LengthKind::edges);
    ASSERT_TRUE(is.true_length_m);
    EXPECT_NEAR(*is.true_length_m, should.length_m, 1e-9);
    for (const auto& [spot, edge] : {std::pair(is.a, should.a), std::pair(is.b, should.b)}) {
      EXPECT_LT((world_from_map * spot.point - edge.middle).norm(), 0.0174) << "half of 2 cm along each axis";
      const Eigen::Vector3d along = world_from_map.rotation() * spot.directions.at(0);
      EXPECT_GT(std::abs(along.dot(edge.direction)), 0.999);
    }
  }
}

}  // namespace
}  // namespace rastro
