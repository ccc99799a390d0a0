// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/corridor_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/synthetic/worlds/corridor_materials.h"

namespace rastro::corridor {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double thick = 0.15;                          // Of walls.
constexpr double door_width = 1.10, door_height = 2.1;  // Between the walls; the posts are inside.
constexpr double post = 0.08, proud = 0.03;             // Posts protrude from the wall.

enum class Door { open, closed, glass };

struct Opening {
  double at = 0.0;  ///< Coordinate of its middle along the wall.
  Door door = Door::open;
};

/// A wall along one of the axes, seen from the side whose face is exactly on the line.
struct WallLine {
  Vector2d from, to;  ///< The wall is thick to the left of this direction.
  std::vector<Opening> openings;
  bool bare = false;
};

class Builder {
 public:
  Builder(Floor& floor, Random& random) : floor_(floor), scene_(*floor.scene), random_(random) {}

  void add(const WallLine& line) {
    line_ = &line;
    along_ = (line.to - line.from).normalized();
    left_ = {-along_.y(), along_.x()};
    std::vector<double> distances;
    for (const Opening& opening : line.openings) distances.push_back(path_of(opening));
    double begin = 0.0;
    std::vector<std::size_t> order(distances.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return distances[a] < distances[b]; });
    for (const std::size_t i : order) {
      block(begin, distances[i] - 0.5 * door_width, 0.0, thick, 0.0, ceiling_m, wall(line.bare));
      add_door(distances[i], line.openings[i].door);
      begin = distances[i] + 0.5 * door_width;
    }
    block(begin, (line.to - line.from).norm(), 0.0, thick, 0.0, ceiling_m, wall(line.bare));
  }

 private:
  double path_of(const Opening& opening) const {
    const bool along_x = std::abs(along_.x()) > 0.5;
    return (opening.at - (along_x ? line_->from.x() : line_->from.y())) * (along_x ? along_.x() : along_.y());
  }
  Vector2d point(double distance, double left) const { return line_->from + distance * along_ + left * left_; }

  void block(double distance0, double distance1, double left0, double left1, double z0, double z1,
             const Material& material) {
    const Vector2d a = point(distance0, left0), b = point(distance1, left1), low = a.cwiseMin(b), high = a.cwiseMax(b);
    add_block(scene_, {low.x(), low.y(), z0}, {high.x(), high.y(), z1}, material);
  }

  void add_door(double distance, Door door) {
    const double half = 0.5 * door_width;
    for (const double side : {-1.0, 1.0}) {
      const double outside = distance + side * half, inside = outside - side * post;
      block(outside, inside, -proud, thick + proud, 0.0, door_height, wood(70.0F));
      floor_.landmarks.push_back({static_cast<std::int64_t>(floor_.landmarks.size()),
                                  point(0.5 * (outside + inside), 0.5 * thick), 0.5 * thick + proud + post});
    }
    block(distance - half, distance + half, 0.0, thick, door_height, ceiling_m, wall(true));
    if (door == Door::open) add_leaf(distance);
    if (door == Door::closed)
      block(distance - half + post, distance + half - post, 0.06, 0.10, 0.0, door_height, wood(120.0F));
    if (door == Door::glass) add_glass(distance);
  }

  /// The leaf of an open door is inside the room, more than 90 degrees open.
  void add_leaf(double distance) {
    const double swing = random_.uniform(1.72, 2.0), length = door_width - 2.0 * post;
    const double side = random_.uniform() < 0.5 ? -1.0 : 1.0;
    const Vector2d hinge = point(distance + side * (0.5 * door_width - post), thick + proud);
    const Vector2d direction = -side * std::cos(swing) * along_ + std::sin(swing) * left_;
    const Vector2d middle = hinge + 0.5 * length * direction;
    scene_.add_box({middle.x(), middle.y(), 0.5 * door_height}, {length, 0.04, door_height - 0.01}, wood(120.0F),
                   std::atan2(direction.y(), direction.x()));
  }

  void add_glass(double distance) {
    const double half = 0.5 * door_width - post;
    floor_.panes.push_back({point(distance - half, 0.5 * thick), point(distance + half, 0.5 * thick)});
    for (const double z : {0.0, 1.0, door_height - 0.1})
      block(distance - half, distance + half, 0.06, 0.10, z, z + 0.1, metal(140.0F));
  }

  Floor& floor_;
  Scene& scene_;
  Random& random_;
  const WallLine* line_ = nullptr;
  Vector2d along_, left_;
};

std::vector<WallLine> corridor_walls() {
  using enum Door;
  return {
      {{outer_east, outer_south},
       {outer_west, outer_south},
       {{-6, open}, {0, glass}, {5, open}, {8.5, closed}, {12.5, open}, {17.5, open}}},
      {{outer_west, outer_north}, {outer_east, outer_north}, {}, true},
      {{outer_west, outer_south}, {outer_west, outer_north}, {{2, open}, {5, closed}, {8, glass}}},
      {{outer_east, outer_north}, {outer_east, outer_south}, {{3, open}, {6.5, closed}}},
      {{inner_west, inner_south}, {inner_east, inner_south}, {{-4, open}, {5, open}, {9, glass}, {15.5, closed}}},
      {{inner_east, inner_north}, {inner_west, inner_north}, {}, true},
      {{inner_west, inner_north}, {inner_west, inner_south}, {}},
      {{inner_east, inner_south}, {inner_east, inner_north}, {{4, closed}}},
  };
}

std::vector<WallLine> room_walls() {
  std::vector<WallLine> walls = {
      {{outer_east + thick, far_south}, {outer_west - thick, far_south}, {}},
      {{far_west, outer_south}, {far_west, outer_north}, {}},
      {{far_east, outer_north}, {far_east, outer_south}, {}},
  };
  for (const double x : {-1.0, 6.0, 12.0}) walls.push_back({{x, inner_south + thick}, {x, inner_north - thick}, {}});
  for (const double x : {outer_west, -3.0, 3.0, 11.0, outer_east + thick})
    walls.push_back({{x, outer_south - thick}, {x, far_south}, {}});
  for (const double y : {outer_south, 4.0, outer_north}) walls.push_back({{outer_west - thick, y}, {far_west, y}, {}});
  for (const double y : {outer_south, 5.0, outer_north}) walls.push_back({{outer_east + thick, y}, {far_east, y}, {}});
  return walls;
}

void add_floor_and_ceiling(Scene& scene) {
  // In pieces, so that no texture is very large.
  const double step = 2.0;
  for (double x = far_west - 1.0; x < far_east + 1.0; x += 2.0 * step)
    for (double y = far_south - 1.0; y < outer_north + 1.0; y += step) {
      scene.add_quad({x + step, y + 0.5 * step, 0.0}, {2.0 * step, 0, 0}, {0, -step, 0}, carpet());
      scene.add_quad({x + step, y + 0.5 * step, ceiling_m}, {2.0 * step, 0, 0}, {0, step, 0}, ceiling());
    }
}

}  // namespace

std::uint32_t add_block(Scene& scene, const Vector3d& low, const Vector3d& high, const Material& material) {
  return scene.add_box(0.5 * (low + high), high - low, material);
}

Floor build_floor(std::uint64_t seed) {
  Floor floor;
  Random doors(seed_for(seed, 1)), furniture(seed_for(seed, 2));
  add_floor_and_ceiling(*floor.scene);
  Builder builder(floor, doors);
  for (const WallLine& line : corridor_walls()) builder.add(line);
  for (const WallLine& line : room_walls()) builder.add(line);
  add_furniture(*floor.scene, furniture);
  add_person(*floor.scene);
  return floor;
}

}  // namespace rastro::corridor
