// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/map_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"

namespace rastro {

void require_camera_of_map(const Camera& of_map, const Camera& of_run) {
  constexpr double most_share = 0.01;
  const double most_px = most_share * of_run.width;
  const double difference_px = std::max({std::abs(of_map.fx - of_run.fx), std::abs(of_map.fy - of_run.fy),
                                         std::abs(of_map.cx - of_run.cx), std::abs(of_map.cy - of_run.cy)});
  if (of_map.width == of_run.width && of_map.height == of_run.height && difference_px <= most_px) return;
  throw Error(fmt::format("was made by another camera ({} x {} pixels, focal length {:.1f} px)", of_map.width,
                          of_map.height, of_map.fx),
              "--map",
              fmt::format("this run has {} x {} pixels, focal length {:.1f} px: give a map of the same camera",
                          of_run.width, of_run.height, of_run.fx));
}

}  // namespace rastro
