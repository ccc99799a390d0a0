// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/street_scene.h"

#include <cmath>
#include <numbers>

#include "rastro/synthetic/worlds/street_drive.h"
#include "rastro/synthetic/worlds/street_materials.h"

namespace rastro::street {
namespace {

using Eigen::Vector3d;

constexpr double corner_m = house_line_m;  // Half the size of a crossing with its pavements.
constexpr double tile_m = 14.0;            // Length of a piece of road.
constexpr double pavement_height = 0.13;

int face_towards(const Eigen::Vector2d& direction) {
  if (std::abs(direction.x()) > 0.5) return direction.x() > 0.0 ? 0 : 1;
  return direction.y() > 0.0 ? 2 : 3;
}

class Builder {
 public:
  Builder(Scene& scene, std::uint64_t seed) : scene_(scene), random_(seed) {}

  void surroundings() {
    const double middle_x = 0.5 * block_x, middle_y = 0.5 * block_y, reach = 420.0, low = -6.0, high = 190.0;
    scene_.add_quad({middle_x, middle_y, -0.03}, {2 * reach, 0, 0}, {0, -2 * reach, 0}, grass());
    const double z = 0.5 * (low + high), height = high - low;
    for (const double side : {-1.0, 1.0}) {
      scene_.add_quad({middle_x + side * reach, middle_y, z}, {0, -side * 2 * reach, 0}, {0, 0, -height}, sky(-low));
      scene_.add_quad({middle_x, middle_y + side * reach, z}, {side * 2 * reach, 0, 0}, {0, 0, -height}, sky(-low));
    }
    scene_.add_quad({middle_x, middle_y, high}, {2 * reach, 0, 0}, {0, 2 * reach, 0}, sky_top());
  }

  void crossings() {
    for (const double x : {0.0, block_x})
      for (const double y : {0.0, block_y}) {
        scene_.add_quad({x, y, 0}, {2 * corner_m, 0, 0}, {0, -2 * corner_m, 0}, crossing());
        const double middle = 0.5 * (kerb_m + corner_m), size = corner_m - kerb_m;
        for (const double side_x : {-1.0, 1.0})
          for (const double side_y : {-1.0, 1.0})
            paved({x + side_x * middle, y + side_y * middle, 0.5 * pavement_height}, {size, size, pavement_height});
      }
  }

  void street(int number) {
    const StreetLine line = street_line(number);
    const double first = street_beyond, second = street_beyond + line.block;
    const bool owns_corners = number % 2 == 0;
    section(line, 0.0, first - corner_m, 0.0, owns_corners ? 0.5 : 12.0);
    section(line, first + corner_m, second - corner_m, owns_corners ? 0.5 : 12.0, owns_corners ? 0.5 : 12.0);
    section(line, second + corner_m, line.length, owns_corners ? 0.5 : 12.0, 0.0);
    // Houses that close the view at both ends.
    for (const double end : {-6.0, line.length + 6.0}) {
      const double height = random_.uniform(10.0, 15.0);
      house(line, end, 0.0, 28.0, 10.0, height, end < 0.0 ? line.along : -line.along);
    }
  }

  void trees_of_the_block() {
    for (int i = 0; i < 60; ++i) {
      const double x = random_.uniform(26.0, block_x - 26.0), y = random_.uniform(26.0, block_y - 26.0);
      tree({x, y, 0}, random_.uniform(1.3, 2.2));
    }
  }

 private:
  void paved(const Vector3d& center, const Vector3d& size) {
    const std::uint32_t box = scene_.add_box(center, size, kerb());
    scene_.paint_face(box, 4, pavement());
    scene_.paint_face(box, 5, plain(60.0F));
  }

  /// A part of a street between two positions along it, without crossings. Houses keep off its ends.
  void section(const StreetLine& line, double begin, double end, double keep_begin, double keep_end) {
    const int tiles = std::max(1, static_cast<int>((end - begin) / tile_m));
    const double length = (end - begin) / tiles, across = house_line_m - kerb_m;
    for (int i = 0; i < tiles; ++i) {
      const double distance = begin + (i + 0.5) * length;
      scene_.add_quad(line.at(distance, 0, 0), -2.0 * kerb_m * line.left3(), -length * line.along3(),
                      road(begin + i * length));
      for (const double side : {-1.0, 1.0})
        paved(line.at(distance, side * (kerb_m + 0.5 * across), 0.5 * pavement_height),
              line.size(length, across, pavement_height));
    }
    for (const double side : {-1.0, 1.0}) {
      row_of_houses(line, begin + keep_begin, end - keep_end, side);
      furniture(line, begin, end, side);
    }
  }

  void row_of_houses(const StreetLine& line, double begin, double end, double side) {
    double distance = begin;
    while (distance < end - 5.0) {
      double width = random_.uniform(7.5, 14.0);
      if (distance + width > end - 5.0) width = end - distance;
      const bool garden = random_.uniform() < 0.35;
      const double setback = garden ? random_.uniform(2.5, 4.5) : random_.uniform(0.0, 0.5);
      const double height = 3.0 * (2 + random_.below(3)) + random_.uniform(0.0, 0.8);
      const double depth = 9.0, middle = distance + 0.5 * width;
      house(line, middle, side * (house_line_m + setback + 0.5 * depth), width - 0.02, depth, height,
            -side * line.left());
      if (garden) front_garden(line, distance, width, setback, side);
      distance += width;
      if (random_.uniform() < 0.3) {
        const double gap = random_.uniform(2.0, 4.0);
        gap_between(line, distance + 0.5 * gap, gap, side);
        distance += gap;
      }
    }
  }

  void house(const StreetLine& line, double distance, double left_m, double width, double depth, double height,
             const Eigen::Vector2d& front) {
    const float tone = static_cast<float>(random_.uniform(82.0, 148.0));
    const int floors = std::max(2, static_cast<int>(height / 3.0));
    const bool faces_along = std::abs(front.dot(line.along)) > 0.5;
    const double along_m = faces_along ? depth : width, across_m = faces_along ? width : depth;
    const std::uint32_t body = scene_.add_box(line.at(distance, left_m, 0.5 * height),
                                              line.size(along_m, across_m, height), house_wall(tone, floors));
    scene_.paint_face(body, face_towards(front), house_front(tone, floors));
    for (const int hidden : {4, 5}) scene_.paint_face(body, hidden, plain(60.0F));
    const Vector3d forward(front.x(), front.y(), 0.0), right(-front.y(), front.x(), 0.0);
    pitched_roof(line.at(distance, left_m, height), forward, right, width, depth);
  }

  /// Two slopes over a stepped gable; `eaves` is the center of the house at the height of its eaves.
  void pitched_roof(const Vector3d& eaves, const Vector3d& forward, const Vector3d& right, double width, double depth) {
    const float tone = static_cast<float>(random_.uniform(60.0, 105.0));
    const double rise = random_.uniform(0.30, 0.48) * depth, over = 0.35;
    const Vector3d up(0, 0, rise), half = (0.5 * depth) * forward;
    for (const double side : {-1.0, 1.0}) {
      const Vector3d down = side * half - up, middle = eaves + 0.5 * (side * half + up);
      const Vector3d longer = (1.0 + over / down.norm()) * down;
      scene_.add_quad(middle + 0.5 * (longer - down), side * width * right, longer, roof(tone));
    }
    constexpr int steps = 4;
    for (int step = 0; step < steps; ++step) {
      const double share = 1.0 - (step + 1.0) / (steps + 0.3), height = rise / (steps + 0.5);
      const Vector3d size =
          (width - 0.1) * right.cwiseAbs() + share * depth * forward.cwiseAbs() + Vector3d(0, 0, height);
      scene_.add_box(eaves + Vector3d(0, 0, (step + 0.5) * height), size, plain(90.0F));
    }
    const double along = random_.uniform(-0.35, 0.35) * width;
    scene_.add_box(eaves + along * right + 0.12 * depth * forward + Vector3d(0, 0, rise + 0.3), {0.7, 0.7, 1.8},
                   garden_wall(86.0F, 30.0));
  }

  void front_garden(const StreetLine& line, double distance, double width, double setback, double side) {
    const double edge = house_line_m + 0.2;
    const bool green = random_.uniform() < 0.5;
    const double height = random_.uniform(0.7, 1.3);
    for (const double part : {0.22, 0.78})
      scene_.add_box(line.at(distance + part * width, side * edge, 0.5 * height), line.size(0.4 * width, 0.4, height),
                     green ? hedge() : garden_wall(112.0F));
    scene_.add_quad(line.at(distance + 0.5 * width, side * (house_line_m + 0.5 * setback), 0.02),
                    -setback * line.left3(), -width * line.along3(), pavement());
    for (int i = 0; i < 2; ++i)
      scene_.add_sphere(line.at(distance + random_.uniform(0.1, 0.9) * width,
                                side * (house_line_m + random_.uniform(0.35, 0.8) * setback), 0.4),
                        random_.uniform(0.35, 0.7), foliage(70.0F));
  }

  void gap_between(const StreetLine& line, double distance, double gap, double side) {
    scene_.add_box(line.at(distance, side * (house_line_m + 1.0), 1.0), line.size(gap, 0.3, 2.0),
                   random_.uniform() < 0.5 ? garden_wall(96.0F) : hedge());
    tree(line.at(distance, side * (house_line_m + 6.0), 0.0), random_.uniform(1.2, 1.8));
  }

  void tree(const Vector3d& foot, double size) {
    const double trunk = random_.uniform(2.0, 2.6) * std::sqrt(size);
    scene_.add_cylinder(foot, foot + Vector3d(0, 0, trunk + 0.8), 0.13 * size, bark());
    const float tone = static_cast<float>(random_.uniform(52.0, 84.0));
    for (int i = 0; i < 15; ++i) {
      const double angle = random_.uniform(0.0, 2.0 * std::numbers::pi), reach = size * random_.uniform(0.1, 1.15);
      scene_.add_sphere(
          foot + Vector3d(reach * std::cos(angle), reach * std::sin(angle), trunk + size * random_.uniform(0.3, 2.0)),
          size * random_.uniform(0.28, 0.66), foliage(tone));
    }
  }

  /// Objects along the kerb: lamps, trees, signs, boxes, parked cars.
  void furniture(const StreetLine& line, double begin, double end, double side) {
    int index = static_cast<int>(random_.below(4));
    for (double distance = begin + random_.uniform(1.0, 3.0); distance < end - 1.5;
         distance += random_.uniform(4.0, 6.5), ++index) {
      const double at = side * (kerb_m + 0.45);
      switch (index % 4) {
        case 0:
          tree(line.at(distance, side * (kerb_m + 0.7), pavement_height), random_.uniform(0.8, 1.15));
          break;
        case 1:
          sign(line.at(distance, at, pavement_height), line);
          break;
        case 2:
          lamp(line, distance, side);
          break;
        default:
          thing(line, distance, side);
      }
    }
    for (double distance = begin + random_.uniform(6.0, 14.0); distance < end - 6.0;
         distance += random_.uniform(7.0, 26.0))
      add_car(scene_, random_, line, distance, side * (kerb_m - 1.0), side > 0.0);
  }

  void lamp(const StreetLine& line, double distance, double side) {
    const Vector3d foot = line.at(distance, side * (kerb_m + 0.45), pavement_height), inward = -side * line.left3();
    const double height = random_.uniform(5.2, 6.2);
    scene_.add_cylinder(foot, foot + Vector3d(0, 0, height), 0.07, pole(92.0F));
    scene_.add_cylinder(foot + Vector3d(0, 0, 0), foot + Vector3d(0, 0, 1.0), 0.11, pole(70.0F));
    scene_.add_cylinder(foot + Vector3d(0, 0, height), foot + 1.5 * inward + Vector3d(0, 0, height + 0.35), 0.04,
                        pole(92.0F));
    scene_.add_box(foot + 1.6 * inward + Vector3d(0, 0, height + 0.35), {0.5, 0.5, 0.14}, street_lamp());
  }

  void sign(const Vector3d& foot, const StreetLine& line) {
    const double height = random_.uniform(2.3, 2.9), size = random_.uniform(0.55, 0.8);
    scene_.add_cylinder(foot, foot + Vector3d(0, 0, height), 0.035, pole(125.0F));
    const Vector3d size3 = line.size(0.04, size, size);
    scene_.add_box(foot + Vector3d(0, 0, height - 0.5 * size) - 0.06 * line.along3(), size3, board());
    if (random_.uniform() < 0.5)
      scene_.add_box(foot + Vector3d(0, 0, height - size - 0.25) - 0.06 * line.along3(), line.size(0.04, size, 0.35),
                     board());
  }

  void thing(const StreetLine& line, double distance, double side) {
    const double kind = random_.uniform();
    const Vector3d foot = line.at(distance, side * (house_line_m - 0.5), pavement_height);
    if (kind < 0.35)
      scene_.add_box(foot + Vector3d(0, 0, 0.6), line.size(0.9, 0.45, 1.2), board());
    else if (kind < 0.7)
      scene_.add_cylinder(foot, foot + Vector3d(0, 0, 0.95), 0.28, garden_wall(80.0F));
    else
      for (int i = 0; i < 3; ++i)
        scene_.add_cylinder(line.at(distance + 1.2 * i, side * (kerb_m + 0.3), pavement_height),
                            line.at(distance + 1.2 * i, side * (kerb_m + 0.3), 1.0), 0.07, pole(140.0F));
  }

  Scene& scene_;
  Random random_;
};

}  // namespace

double StreetLine::heading() const { return std::atan2(along.y(), along.x()); }

Vector3d StreetLine::size(double along_m, double across_m, double height) const {
  const Vector3d size = along_m * along3() + across_m * left3();
  return {std::abs(size.x()), std::abs(size.y()), height};
}

StreetLine street_line(int number) {
  constexpr double end_x = block_x + street_beyond, end_y = block_y + street_beyond;
  switch (number) {
    case 0:
      return {{-street_beyond, 0.0}, {1.0, 0.0}, block_x + 2.0 * street_beyond, block_x};
    case 1:
      return {{block_x, -street_beyond}, {0.0, 1.0}, block_y + 2.0 * street_beyond, block_y};
    case 2:
      return {{end_x, block_y}, {-1.0, 0.0}, block_x + 2.0 * street_beyond, block_x};
    default:
      return {{0.0, end_y}, {0.0, -1.0}, block_y + 2.0 * street_beyond, block_y};
  }
}

std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail) {
  auto scene = std::make_unique<Scene>();
  Builder builder(*scene, seed_for(seed, 1));
  builder.surroundings();
  builder.crossings();
  for (int number = 0; number < 4; ++number) builder.street(number);
  builder.trees_of_the_block();
  Random traffic(seed_for(seed, 3));
  add_traffic(*scene, traffic);
  TaskPool pool(threads);
  scene->bake(seed_for(seed, 2), pool, detail, 0.7);
  return scene;
}

}  // namespace rastro::street
