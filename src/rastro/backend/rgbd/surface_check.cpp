// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/surface_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/map/images/packed_depth.h"

namespace rastro {
namespace {

constexpr double block_middle = 0.5 * (surface_block_px - 1);

}  // namespace

SurfaceCheck::SurfaceCheck(const Camera& camera, const SurfaceOptions& options)
    : camera_(camera),
      options_(options),
      noise_{options.depth_sigma_m, options.depth_sigma_per_m2},
      icp_(camera, options) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  width_ = camera.width / surface_block_px;
  height_ = camera.height / surface_block_px;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x)
      rays_.push_back(camera.unproject({x * surface_block_px + block_middle, y * surface_block_px + block_middle})
                          .value_or(Eigen::Vector2d(none, none)));
  }
}

KeyframeSurface SurfaceCheck::surface_of(const DepthImage& depth) const {
  return surface_of_unpacked(rounded_as_packed(depth));
}

KeyframeSurface SurfaceCheck::surface_of_unpacked(const DepthImage& depth) const {
  KeyframeSurface surface;
  if (depth.width() != camera_.width || depth.height() != camera_.height) return surface;
  surface.blocks = depth_blocks(depth, {}, options_);
  surface.planes = icp_.planes(surface.blocks);
  return surface;
}

SurfaceFit SurfaceCheck::fit(const KeyframeSurface& a, const KeyframeSurface& b, const SE3& a_from_b,
                             double reach_m) const {
  if (a.blocks.empty() || b.blocks.empty()) return {};
  return icp_.compare(a.planes, b.blocks, a_from_b, reach_m, 2);
}

SurfaceAgreement SurfaceCheck::compare(const KeyframeSurface& a, const KeyframeSurface& b, const SE3& a_from_b) const {
  SurfaceAgreement sum;
  if (a.blocks.empty() || b.blocks.empty()) return sum;
  count(b.blocks, a.blocks, a_from_b, sum);
  count(a.blocks, b.blocks, a_from_b.inverse(), sum);
  return sum;
}

void SurfaceCheck::count(const DepthBlocks& seen, const DepthBlocks& by, const SE3& by_from_seen,
                         SurfaceAgreement& sum) const {
  constexpr int stride = 2;
  constexpr double sigmas = 3.0;
  const Eigen::Matrix3d rotation = by_from_seen.rotation().matrix();
  for (int y = 0; y < height_; y += stride) {
    for (int x = 0; x < width_; x += stride) {
      const auto depth = static_cast<double>(seen.depth[static_cast<std::size_t>(y * width_ + x)]);
      const Eigen::Vector2d& ray =
          rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
      if (depth <= 0.0 || !std::isfinite(ray.x())) continue;
      const Eigen::Vector3d point =
          rotation * (depth * Eigen::Vector3d(ray.x(), ray.y(), 1.0)) + by_from_seen.translation();
      const std::optional<Eigen::Vector2d> pixel = camera_.project(point);
      const double u = pixel ? (pixel->x() - block_middle) / surface_block_px : -1.0,
                   v = pixel ? (pixel->y() - block_middle) / surface_block_px : -1.0;
      if (!(u >= 1.0 && v >= 1.0 && u < width_ - 2 && v < height_ - 2)) {
        ++sum.outside;
        continue;
      }
      // At a depth discontinuity one pixel decides what is visible, so the neighbors are considered.
      float nearest = std::numeric_limits<float>::infinity(), farthest = 0.0F;
      const int cu = static_cast<int>(u + 0.5), cv = static_cast<int>(v + 0.5);
      for (int j = cv - 1; j <= cv + 1; ++j) {
        for (int i = cu - 1; i <= cu + 1; ++i) {
          const float there = by.depth[static_cast<std::size_t>(j * width_ + i)];
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
