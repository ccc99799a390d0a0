// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/ray_observations.h"

#include <algorithm>

#include "rastro/math/median.h"

namespace rastro {

const Eigen::Vector2d* find_ray(const RayObservations& observations, std::int64_t id) {
  const auto found =
      std::lower_bound(observations.begin(), observations.end(), id,
                       [](const RayObservation& observation, std::int64_t wanted) { return observation.id < wanted; });
  return found != observations.end() && found->id == id ? &found->ray : nullptr;
}

SharedRays shared_rays(const RayObservations& first, const RayObservations& second) {
  SharedRays shared;
  for (const RayObservation& observation : second) {
    if (const Eigen::Vector2d* ray = find_ray(first, observation.id)) {
      shared.a.push_back(*ray);
      shared.b.push_back(observation.ray);
      shared.ids.push_back(observation.id);
    }
  }
  return shared;
}

double median_motion_px(const SharedRays& shared, double focal_px) {
  std::vector<double> motions;
  for (std::size_t i = 0; i < shared.a.size(); ++i) motions.push_back(focal_px * (shared.b[i] - shared.a[i]).norm());
  return upper_median_or(std::move(motions), 0.0);
}

}  // namespace rastro
