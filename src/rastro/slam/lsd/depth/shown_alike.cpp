// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/shown_alike.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

double bilinear(GrayView image, const Eigen::Vector2d& at) {
  const int left = static_cast<int>(at.x()), top = static_cast<int>(at.y());
  const double right = at.x() - left, bottom = at.y() - top;
  const auto row = [&](int y) { return (1.0 - right) * image.at(left, y) + right * image.at(left + 1, y); };
  return (1.0 - bottom) * row(top) + bottom * row(top + 1);
}

double squared_gradient(GrayView image, int x, int y) {
  const double across = 0.5 * (image.at(x + 1, y) - image.at(x - 1, y)),
               upright = 0.5 * (image.at(x, y + 1) - image.at(x, y - 1));
  return across * across + upright * upright;
}

}  // namespace

bool is_shown_alike(GrayView here, int x, int y, GrayView other, const Eigen::Vector2d& there,
                    const ShownAlikeOptions& options) {
  constexpr double brightest = 255.0;
  const double squared_gain = options.gain * options.gain;
  const double expected = std::clamp(options.gain * here.at(x, y) + options.offset, 0.0, brightest);
  const double difference = bilinear(other, there) - expected;
  const int u = static_cast<int>(std::lround(there.x())), v = static_cast<int>(std::lround(there.y()));
  const double gradient = std::max(squared_gain * squared_gradient(here, x, y), squared_gradient(other, u, v));
  const double variance =
      (1.0 + squared_gain) * options.intensity_sigma * options.intensity_sigma + options.position_variance * gradient;
  return difference * difference <= options.max_sigmas * options.max_sigmas * variance;
}

}  // namespace rastro
