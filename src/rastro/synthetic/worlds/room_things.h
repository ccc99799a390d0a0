// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/random.h"
#include "rastro/synthetic/named_length.h"
#include "rastro/synthetic/scene.h"

namespace rastro::room {

// Objects at home, built from solids. World frame: x to the wall that the camera faces first, y to the left, z up, the
// floor at z = 0; meters.

std::uint32_t add_block(Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                        const Material& material);

struct Shell {
  Eigen::Vector3d low, high;  ///< The room's inside.
  Material walls[4];          ///< Ahead, left, behind, right.
  Material floor;
};
void add_shell(Scene& scene, const Shell& shell);

/// Books side by side on a board: from `from` (front, bottom) `along` the front, standing `inward`.
struct BookRow {
  Eigen::Vector3d from, along, inward;  ///< The last two of unit length, along the world's axes.
  double length = 1.0, height = 0.24;   ///< Maximum height.
};
void add_books(Scene& scene, Random& random, const BookRow& row);
/// A pile of books on their sides.
void add_pile(Scene& scene, Random& random, const Eigen::Vector3d& at, int books);

/// A case of boards whose front is the face at `low.x()` (facing backwards).
struct Bookcase {
  Eigen::Vector3d low, high;
  std::vector<double> boards;  ///< Heights of the tops of its boards.
  Material material;
};
void add_bookcase(Scene& scene, const Bookcase& bookcase);
constexpr double board_m = 0.025;

void add_table(Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Material& top);
void add_chair(Scene& scene, const Eigen::Vector3d& at, double yaw, const Material& cover);
void add_plant(Scene& scene, Random& random, const Eigen::Vector3d& at, double size);
void add_lamp(Scene& scene, const Eigen::Vector3d& foot, double height);

/// Distance between two parallel edges of a box's face: `across` is the measured axis, `along` that of the edges,
/// `normal` the outward direction of the face (an axis, with its sign).
NamedLength box_length(const std::string& name, const Eigen::Vector3d& low, const Eigen::Vector3d& high, int across,
                       int along, const Eigen::Vector3d& normal);

}  // namespace rastro::room
