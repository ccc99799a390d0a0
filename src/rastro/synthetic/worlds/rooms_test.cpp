// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/rooms.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/worlds/room_scenes.h"

namespace rastro {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

const World& small_room(bool study) {
  static const World bedroom = make_bedroom({.scale = 0.125, .threads = 2});
  static const World work = make_study({.scale = 0.125, .threads = 2});
  return study ? work : bedroom;
}

const NamedLength& length_of(const World& world, const std::string& name) {
  for (const NamedLength& length : world.lengths())
    if (length.name == name) return length;
  throw Error("no such length", name, "");
}

/// Whether a ray straight down to a point of the face's plane hits the face's solid or pane there.
bool is_on_face(const World& world, const NamedLength& length, const Eigen::Vector3d& normal,
                const Eigen::Vector3d& point) {
  const Eigen::Vector3d origin = point + 0.02 * normal;
  for (const GlassSheet& sheet : world.scene().glass())
    if (std::isfinite(sheet.intersect(origin + normal, -normal)) &&
        std::abs((sheet.center - point).dot(normal)) < 0.006)
      return true;
  const auto hit = world.scene().trace(origin, -normal, 0.03);
  const auto face = world.scene().trace(length.face + 0.02 * normal, -normal, 0.03);
  return hit && face && hit->surface == face->surface && std::abs(hit->t - 0.02) < 1e-9;
}

/// Each edge is the end of the face: a millimeter inside there is face, a millimeter outside there is none.
void expect_true(const World& world, const std::string& name, double should_m) {
  const NamedLength& length = length_of(world, name);
  EXPECT_NEAR(length.length_m, should_m, 1e-12) << name;
  EXPECT_NEAR((length.a.middle - length.b.middle).norm(), should_m, 1e-12) << name;
  const Eigen::Vector3d across = (length.b.middle - length.a.middle).normalized();
  Eigen::Vector3d normal = across.cross(length.a.direction).normalized();
  if (normal.dot(world.world_from_camera(0).translation() - length.face) < 0.0) normal = -normal;
  for (const auto& [edge, outward] : {std::pair(length.a, Eigen::Vector3d(-across)), std::pair(length.b, across)})
    for (const double along : {-0.05, -0.02, 0.02}) {
      const Eigen::Vector3d point = edge.middle + along * edge.direction;
      EXPECT_TRUE(is_on_face(world, length, normal, point - 0.001 * outward)) << name << ' ' << along;
      EXPECT_FALSE(is_on_face(world, length, normal, point + 0.001 * outward)) << name << ' ' << along;
    }
}

TEST(Rooms, named_lengths_are_exact) {
  expect_true(small_room(false), "blue box width", 0.32);
  expect_true(small_room(false), "blue box height", 0.25);
  expect_true(small_room(false), "bed length", 2.0);
  expect_true(small_room(true), "shelf height", 0.16);
  expect_true(small_room(true), "shelf width", 0.75);
  expect_true(small_room(true), "calendar height", 0.42);
  expect_true(small_room(true), "glass table width", 0.85);
}

TEST(Rooms, the_walk_is_hand_held_and_ends_at_its_start) {
  for (const bool study : {false, true}) {
    const World& world = small_room(study);
    const double swing_s = study ? study_swing_s : bedroom_swing_s, round_s = study ? study_round_s : bedroom_round_s;
    const SE3 home = world.world_from_camera_at(0.0).inverse() * world.world_from_camera_at(round_s);
    EXPECT_LT(home.translation().norm(), 0.08);
    double fastest = 0.0;
    for (int frame = 0; frame < 6000; frame += frame < 1200 ? 1 : 5) {
      const double time = world.time_of(frame);
      const SE3 here = world.world_from_camera(frame);
      ASSERT_FALSE(world.scene().touches(here.translation(), 0.30)) << "frame " << frame;
      const SE3 step = here.inverse() * world.world_from_camera(frame + 1);
      const double rotation_rate = step.rotation().log().norm() * world.rate_hz() / degree;
      ASSERT_LT(step.translation().norm() * world.rate_hz(), 0.8) << "frame " << frame;
      if (time > swing_s - 0.1 && time < swing_s + 1.1)
        fastest = std::max(fastest, rotation_rate);
      else
        ASSERT_LT(rotation_rate, 65.0) << "frame " << frame;
    }
    EXPECT_GT(fastest, 150.0);
    EXPECT_LT(fastest, 230.0);
  }
}

TEST(Rooms, the_bed_is_never_seen_frontally_but_both_its_ends_are_visible) {
  const World& world = small_room(false);
  const NamedLength& bed = length_of(world, "bed length");
  int both_seen = 0;
  for (int frame = 0; frame < static_cast<int>(bedroom_round_s * world.rate_hz()); ++frame) {
    const PointView a = world.view_of(frame, bed.a.middle), b = world.view_of(frame, bed.b.middle);
    if (!a.visible && !b.visible) continue;
    both_seen += a.visible && b.visible ? 1 : 0;
    Eigen::Vector3d axis = world.world_from_camera(frame).rotation() * Eigen::Vector3d::UnitZ();
    axis.z() = 0.0;
    const double off = std::acos(axis.normalized().y()) / degree;
    ASSERT_GT(off, 30.0) << "frame " << frame;
  }
  EXPECT_GT(both_seen, 30);
}

TEST(Rooms, the_box_is_blue_and_rendering_does_not_depend_on_threads) {
  const World& world = small_room(false);
  const World again = make_bedroom({.scale = 0.125, .threads = 1});
  TaskPool one(1), eight(8);
  const RenderedFrame a = world.render(10, eight), b = again.render(10, one);
  for (int y = 0; y < a.color.height(); ++y)
    ASSERT_EQ(0, std::memcmp(a.color.rgb.row(y), b.color.rgb.row(y), static_cast<std::size_t>(a.color.rgb.width())));
  const NamedLength& width = length_of(world, "blue box width");
  const PointView corner = world.view_of(10, width.face + Eigen::Vector3d(0, 0.12, -0.10));
  ASSERT_TRUE(corner.inside);
  const std::uint8_t* pixel = a.color.rgb.row(static_cast<int>(std::lround(corner.pixel.y()))) +
                              3 * static_cast<int>(std::lround(corner.pixel.x()));
  EXPECT_GT(pixel[2], pixel[0] + 40) << "blue against red";
  EXPECT_THROW(make_bedroom({.scale = 100}), Error);
}

TEST(Rooms, glass_has_no_depth_or_that_of_the_surface_behind) {
  const World& world = small_room(true);
  TaskPool pool(2);
  const KinectModel model = *world.kinect();
  int none = 0, behind = 0, on_glass = 0;
  for (const double time : {15.0, 16.5, 18.0}) {
    const RenderedFrame exact = world.depth_at(time, pool);
    const SE3 pose = world.world_from_camera_at(time);
    const Image<std::uint16_t> raw = kinect_depth(exact, world.renderer(), pose, model, 3, pool);
    for (int y = 0; y < raw.height(); ++y)
      for (int x = 0; x < raw.width(); ++x) {
        const double glass = world.scene().glass().at(0).intersect(
            pose.translation(), pose.rotation().matrix() * world.renderer().ray(x, y));
        const auto z = static_cast<double>(exact.depth.at(x, y));
        if (!(glass < z - 0.3)) continue;
        none += raw.at(x, y) == 0 ? 1 : 0;
        behind += raw.at(x, y) / model.units_per_meter > 0.5 * (glass + z) ? 1 : 0;
        on_glass += std::abs(raw.at(x, y) / model.units_per_meter - glass) < 0.03 ? 1 : 0;
      }
  }
  EXPECT_GT(none, 100);
  EXPECT_GT(behind, 100);
  EXPECT_LT(on_glass, (none + behind) / 50) << "only where the camera's blur reaches over the table's rim";
}

}  // namespace
}  // namespace rastro
