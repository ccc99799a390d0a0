// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/depth_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rastro {

DepthGrid::DepthGrid(const DepthImage& depth)
    : width_((depth.width() + step_px - 1) / step_px), height_((depth.height() + step_px - 1) / step_px) {
  units_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const double units =
          std::round(static_cast<double>(depth.at(x * step_px, y * step_px)) * packed_depth_units_per_metre);
      units_.push_back(units > 0.0 && units <= 65535.0 ? static_cast<std::uint16_t>(units) : std::uint16_t{0});
    }
  }
}

SurfaceCheck::SurfaceCheck(const Camera& camera, const DepthNoise& noise) : camera_(camera), noise_(noise) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  constexpr int step = DepthGrid::step_px;
  width_ = (camera.width + step - 1) / step;
  height_ = (camera.height + step - 1) / step;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x)
      rays_.push_back(camera.unproject({static_cast<double>(x * step), static_cast<double>(y * step)})
                          .value_or(Eigen::Vector2d(none, none)));
  }
}

SurfaceAgreement SurfaceCheck::compare(const DepthGrid& a, const DepthGrid& b, const SE3& a_from_b) const {
  SurfaceAgreement sum;
  const auto fits = [this](const DepthGrid& grid) { return grid.width() == width_ && grid.height() == height_; };
  if (!fits(a) || !fits(b)) return sum;
  count(b, a, a_from_b, sum);
  count(a, b, a_from_b.inverse(), sum);
  return sum;
}

void SurfaceCheck::count(const DepthGrid& seen, const DepthGrid& by, const SE3& by_from_seen,
                         SurfaceAgreement& sum) const {
  constexpr int stride = 2;
  constexpr double sigmas = 3.0;
  const Eigen::Matrix3d rotation = by_from_seen.rotation().matrix();
  for (int y = 0; y < height_; y += stride) {
    for (int x = 0; x < width_; x += stride) {
      const auto depth = static_cast<double>(seen.at(x, y));
      const Eigen::Vector2d& ray =
          rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
      if (depth <= 0.0 || !std::isfinite(ray.x())) continue;
      const Eigen::Vector3d point =
          rotation * (depth * Eigen::Vector3d(ray.x(), ray.y(), 1.0)) + by_from_seen.translation();
      const std::optional<Eigen::Vector2d> pixel = camera_.project(point);
      const double u = pixel ? pixel->x() / DepthGrid::step_px : -1.0,
                   v = pixel ? pixel->y() / DepthGrid::step_px : -1.0;
      if (!(u >= 1.0 && v >= 1.0 && u < width_ - 2 && v < height_ - 2)) {
        ++sum.outside;
        continue;
      }
      // At the rim of a thing a pixel more or less decides what is seen, so the neighbours have a say.
      float nearest = std::numeric_limits<float>::infinity(), farthest = 0.0F;
      const int cu = static_cast<int>(u + 0.5), cv = static_cast<int>(v + 0.5);
      for (int j = cv - 1; j <= cv + 1; ++j) {
        for (int i = cu - 1; i <= cu + 1; ++i) {
          const float there = by.at(i, j);
          if (there <= 0.0F) continue;
          nearest = std::min(nearest, there);
          farthest = std::max(farthest, there);
        }
      }
      const double allowed = sigmas * (noise_.sigma(point.z()) + noise_.sigma(depth)) + 0.01 * point.z();
      if (farthest <= 0.0F)
        ++sum.outside;
      else if (point.z() < static_cast<double>(nearest) - allowed)
        ++sum.contradict;
      else if (point.z() > static_cast<double>(farthest) + allowed)
        ++sum.hidden;
      else
        ++sum.agree;
    }
  }
}

}  // namespace rastro
