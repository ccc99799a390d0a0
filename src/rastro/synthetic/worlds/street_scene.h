// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "rastro/base/random.h"
#include "rastro/synthetic/scene.h"

namespace rastro::street {

/// World frame: x east, y north, z up, the road at z = 0; the streets are those of street_drive.h.
std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail = 1.0);

/// One of the four streets, as the drive passes it: along it, the block is on the left.
struct StreetLine {
  Eigen::Vector2d from, along;
  double length = 0.0;
  double block = 0.0;  ///< From the first crossing to the second one.

  Eigen::Vector2d left() const { return {-along.y(), along.x()}; }
  /// `distance` meters along the street, `left_m` to the left of its center line.
  Eigen::Vector3d at(double distance, double left_m, double z) const {
    const Eigen::Vector2d point = from + distance * along + left_m * left();
    return {point.x(), point.y(), z};
  }
  Eigen::Vector3d along3() const { return {along.x(), along.y(), 0.0}; }
  Eigen::Vector3d left3() const { return {-along.y(), along.x(), 0.0}; }
  double heading() const;
  /// Size of a box that is `along_m` by `across_m` by `height`, in the world's axes.
  Eigen::Vector3d size(double along_m, double across_m, double height) const;
};
StreetLine street_line(int number);

constexpr double kerb_m = 5.4;        ///< From the center line of the street to the kerb.
constexpr double house_line_m = 8.4;  ///< And to the edge of the pavement.

/// A parked car on `line`, its center at (distance, left_m), pointing along the street or against it.
void add_car(Scene& scene, Random& random, const StreetLine& line, double distance, double left_m, bool against);
/// Moving cars. Periodic in the time of a lap of the drive, so that every lap has the same events.
void add_traffic(Scene& scene, Random& random);

}  // namespace rastro::street
