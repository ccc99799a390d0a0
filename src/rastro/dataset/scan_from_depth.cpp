// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/scan_from_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"

namespace rastro {

ScanFromDepth::ScanFromDepth(const Camera& camera, const ScanFromDepthOptions& options)
    : width_(camera.width), height_(camera.height), options_(options) {
  if (!(options.lowest < options.highest))
    throw Error(fmt::format("{}:{} is not a range of heights", options.lowest, options.highest), "--height",
                "give A:B in meters with A below B");
  if (!(options.min_range < options.max_range) || !std::isfinite(options.max_range))
    throw Error(fmt::format("a reach of {} m is not above {} m", options.max_range, options.min_range), "--max-range",
                "give meters");
  if (width_ < 1 || height_ < 1 || !(camera.fx > 0.0) || !(camera.fy > 0.0))
    throw Error("the camera has no size or no focal length", "calibration", "give --intrinsics");
  angle_step_ = 1.0 / camera.fx;
  double rightmost = 0.0, leftmost = 0.0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const auto ray = camera.unproject({x, y});
      Ray& kept = rays_.emplace_back();
      kept.right = ray ? static_cast<float>(ray->x()) : std::numeric_limits<float>::quiet_NaN();
      kept.down = ray ? static_cast<float>(ray->y()) : std::numeric_limits<float>::quiet_NaN();
      if (!ray) continue;
      rightmost = std::max(rightmost, std::atan(ray->x()));
      leftmost = std::min(leftmost, std::atan(ray->x()));
    }
  }
  const int right_beams = static_cast<int>(std::lround(rightmost / angle_step_));
  beams_ = right_beams + static_cast<int>(std::lround(-leftmost / angle_step_)) + 1;
  first_angle_ = -right_beams * angle_step_;
  for (Ray& ray : rays_) {
    if (std::isnan(ray.right)) continue;
    const long beam = std::lround((-std::atan(static_cast<double>(ray.right)) - first_angle_) / angle_step_);
    ray.beam = static_cast<int>(std::clamp<long>(beam, 0, beams_ - 1));
  }
}

LaserScan ScanFromDepth::cut(const DepthImage& depth) const {
  RASTRO_CHECK(depth.width() == width_ && depth.height() == height_, "depth of another size than the camera");
  LaserScan scan;
  scan.first_angle = first_angle_;
  scan.angle_step = angle_step_;
  scan.min_range = options_.min_range;
  scan.max_range = options_.max_range;
  constexpr float none = std::numeric_limits<float>::infinity();
  std::vector<float> nearest(static_cast<std::size_t>(beams_), none);
  const auto lowest = static_cast<float>(options_.lowest), highest = static_cast<float>(options_.highest);
  for (int y = 0; y < height_; ++y) {
    const Ray* ray = &rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_)];
    for (int x = 0; x < width_; ++x, ++ray) {
      const float forward = depth.at(x, y);
      const float height = -ray->down * forward;
      // Written so that a ray that is not a number fails.
      if (!(forward > 0.0F && height >= lowest && height <= highest)) continue;
      const float range = forward * std::sqrt(1.0F + ray->right * ray->right);
      float& best = nearest[static_cast<std::size_t>(ray->beam)];
      if (range > static_cast<float>(options_.min_range)) best = std::min(best, range);
    }
  }
  scan.ranges = std::move(nearest);
  for (float& range : scan.ranges)
    if (range == none) range = 0.0F;
  return scan;
}

}  // namespace rastro
