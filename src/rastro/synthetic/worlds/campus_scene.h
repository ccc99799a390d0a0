// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/synthetic/scene.h"

namespace rastro::campus {

/// World frame: see campus_plan.h. Painted.
std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail);

/// Walls, floors, ceilings, doors, windows and stairs; what hangs on the walls differs for another `random`.
void add_building(Scene& scene, Random& random);
/// Facades, parking lot, courtyard, houses and trees around.
void add_grounds(Scene& scene, Random& random);
/// People who walk to and fro in the corridors and outside; must be added last.
void add_walkers(Scene& scene, Random& random);

/// Objects that stand in the same place in every lap, or elsewhere or not at all in some of them.
class LapThings {
 public:
  /// Adds the solids of an object to the scene.
  using Build = std::function<void(Scene&, Random&)>;

  LapThings(Scene& scene, std::uint64_t seed) : scene_(scene), random_(seed) {}
  /// An object at `position`. One of three moves by up to 1.8 m along `free` (a unit vector) from lap to lap or is gone
  /// in some laps; it moves while the camera is half a lap away.
  void add(const Eigen::Vector3d& position, const Eigen::Vector3d& free, const Build& build);
  /// The object of the first lap, and others that stand in its place in the later ones; 0: none.
  void replace(const Eigen::Vector3d& position, const std::vector<Build>& builds);
  /// Adds the objects that move; after all static ones.
  void add_moving();
  Random& random() { return random_; }

 private:
  struct Moving {
    Build build;
    std::uint64_t seed = 0;
    double at_m = 0.0;                     ///< Path length of a lap nearest to it.
    std::vector<Eigen::Vector3d> offsets;  ///< In each lap.
  };

  Scene& scene_;
  Random random_;
  std::vector<Moving> moving_;
};

/// Furniture in the corridors, benches and bicycles in the courtyard, and parked cars.
void add_things(LapThings& things);

/// Where an object is that is gone: below the ground.
inline const Eigen::Vector3d gone_m(0.0, 0.0, -60.0);

std::uint32_t add_block(Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                        const Material& material);

/// A vertical wall in pieces of a bay, visible from the right of `from` - `to`.
struct Opening {
  double begin, end, top;  ///< Meters along the wall, and height above its foot.
};
struct Wall {
  Eigen::Vector2d from, to;
  double low = 0.0, high = 0.0;  ///< z
  std::vector<Opening> openings = {};

  double length() const { return (to - from).norm(); }
  Eigen::Vector2d along() const { return (to - from).normalized(); }
  Eigen::Vector2d out() const { return {along().y(), -along().x()}; }
  /// `distance` along it, `off` before it, at height z.
  Eigen::Vector3d at(double distance, double off, double z) const {
    const Eigen::Vector2d point = from + distance * along() + off * out();
    return {point.x(), point.y(), z};
  }
  /// Whether the part between two distances is free of openings.
  bool closed(double begin, double end) const {
    for (const Opening& opening : openings)
      if (opening.begin < end && opening.end > begin) return false;
    return true;
  }
};
void add_wall(Scene& scene, const Wall& wall, const Material& material);
/// A thin box on a wall: its center `distance` along and at height z above the wall's foot.
void add_panel(Scene& scene, const Wall& wall, double distance, double z, const Eigen::Vector2d& size, double thick,
               const Material& material);

/// The walls of the corridors of one floor (0 or 1): outer and inner ones in turn, in the south, north, west and east.
std::vector<Wall> corridor_walls(int storey);

}  // namespace rastro::campus
