// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/projective_icp.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

constexpr int block = surface_block_px;
constexpr float least_pixels = 0.75F * block * block;
// Depth may vary by this share within a block: a surface at 15 degrees from edge-on.
constexpr float most_spread = 0.03F;
constexpr int plane_reach = 2;  // blocks on each side in the fit of a plane
constexpr double most_noises = 3.0;
// Surfaces seen at a smaller angle count as edges.
constexpr float least_facing = 0.15F;
constexpr double fitting_noises = 3.0;
constexpr int overlap_step = 10;

/// Sums of one column over the rows of a block.
struct ColumnSums {
  explicit ColumnSums(int width)
      : sum(static_cast<std::size_t>(width)),
        count(static_cast<std::size_t>(width)),
        least(static_cast<std::size_t>(width)),
        most(static_cast<std::size_t>(width)) {}
  void clear() {
    std::fill(sum.begin(), sum.end(), 0.0F);
    std::fill(count.begin(), count.end(), 0.0F);
    std::fill(least.begin(), least.end(), std::numeric_limits<float>::max());
    std::fill(most.begin(), most.end(), 0.0F);
  }
  void add(const float* row, float min_depth, float max_depth) {
    for (std::size_t x = 0; x < sum.size(); ++x) {
      const float z = row[x];
      const bool measured = z >= min_depth && z <= max_depth;
      sum[x] += measured ? z : 0.0F;
      count[x] += measured ? 1.0F : 0.0F;
      least[x] = std::min(least[x], measured ? z : std::numeric_limits<float>::max());
      most[x] = std::max(most[x], measured ? z : 0.0F);
    }
  }
  /// Mean of the block whose first column is `x`; 0 if it is not one surface.
  float mean(std::size_t x) const {
    float total = 0.0F, pixels = 0.0F, low = std::numeric_limits<float>::max(), high = 0.0F;
    for (std::size_t i = x; i < x + block; ++i) {
      total += sum[i];
      pixels += count[i];
      low = std::min(low, least[i]);
      high = std::max(high, most[i]);
    }
    if (pixels < least_pixels || high - low > most_spread * low) return 0.0F;
    return total / pixels;
  }

  std::vector<float> sum, count, least, most;
};

void leave_out_masked(GrayView mask, DepthBlocks& blocks) {
  for (int y = 0; y < blocks.height * block; ++y) {
    const std::uint8_t* row = mask.row(y);
    float* depth = blocks.depth.data() + y / block * blocks.width;
    for (int x = 0; x < blocks.width * block; ++x) {
      if (row[x] == 0) depth[x / block] = 0.0F;
    }
  }
}

/// Inverse depth about the center of a window of blocks, and its gradient per block.
struct InverseDepthSlope {
  float mean = 0.0F, across = 0.0F, down = 0.0F;
};

/// The same for the window around a block; nullopt if a block has no depth or the window is not planar.
std::optional<InverseDepthSlope> inverse_depth_slope(const DepthBlocks& blocks, int x, int y,
                                                     const SurfaceOptions& options) {
  constexpr int side = 2 * plane_reach + 1;
  // Sum of the squares of the offsets over the window.
  constexpr float squares = static_cast<float>(side * plane_reach * (plane_reach + 1) * side) / 3.0F;
  float q[side][side];
  float sum = 0.0F, across = 0.0F, down = 0.0F;
  bool whole = true;
  for (int dy = -plane_reach; dy <= plane_reach && whole; ++dy) {
    for (int dx = -plane_reach; dx <= plane_reach; ++dx) {
      const float z = blocks.depth[static_cast<std::size_t>((y + dy) * blocks.width + x + dx)];
      whole = whole && z > 0.0F;
      const float inverse = 1.0F / std::max(z, 1e-3F);
      q[dy + plane_reach][dx + plane_reach] = inverse;
      sum += inverse;
      across += static_cast<float>(dx) * inverse;
      down += static_cast<float>(dy) * inverse;
    }
  }
  if (!whole) return std::nullopt;
  const float mean = sum / (side * side);
  across /= squares;
  down /= squares;
  const float noise =
      static_cast<float>(options.depth_sigma_per_m2 + options.depth_sigma_m * static_cast<double>(mean * mean));
  for (int dy = -plane_reach; dy <= plane_reach && whole; ++dy) {
    for (int dx = -plane_reach; dx <= plane_reach; ++dx) {
      const float off = q[dy + plane_reach][dx + plane_reach] - mean - static_cast<float>(dx) * across -
                        static_cast<float>(dy) * down;
      whole = whole && std::abs(off) < static_cast<float>(most_noises) * noise;
    }
  }
  if (!whole) return std::nullopt;
  return InverseDepthSlope{mean, across, down};
}

}  // namespace

DepthBlocks depth_blocks(const DepthImage& depth, GrayView mask, const SurfaceOptions& options) {
  DepthBlocks blocks{depth.width() / block, depth.height() / block, {}};
  blocks.depth.resize(static_cast<std::size_t>(blocks.width) * static_cast<std::size_t>(blocks.height));
  ColumnSums columns(blocks.width * block);
  for (int y = 0; y < blocks.height; ++y) {
    columns.clear();
    for (int i = 0; i < block; ++i)
      columns.add(depth.row(y * block + i), static_cast<float>(options.min_depth_m),
                  static_cast<float>(options.max_depth_m));
    for (int x = 0; x < blocks.width; ++x)
      blocks.depth[static_cast<std::size_t>(y * blocks.width + x)] = columns.mean(static_cast<std::size_t>(x * block));
  }
  if (mask.width == depth.width() && mask.height == depth.height()) leave_out_masked(mask, blocks);
  return blocks;
}

ProjectiveIcp::ProjectiveIcp(const Camera& camera, const SurfaceOptions& options)
    : camera_(camera), options_(options), width_(camera.width / block), height_(camera.height / block) {
  constexpr double middle = 0.5 * (block - 1);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const auto ray = camera_.unproject({x * block + middle, y * block + middle});
      // Where the distortion cannot be inverted there is no point; a NaN ray fits nothing.
      rays_.push_back(ray ? Eigen::Vector2f(ray->cast<float>()) : Eigen::Vector2f::Constant(std::nanf("")));
    }
  }
}

Eigen::Vector3d ProjectiveIcp::point_of(const DepthBlocks& blocks, int x, int y) const {
  const std::size_t i = static_cast<std::size_t>(y * width_ + x);
  const double z = static_cast<double>(blocks.depth[i]);
  return {static_cast<double>(rays_[i].x()) * z, static_cast<double>(rays_[i].y()) * z, z};
}

std::vector<BlockPlane> ProjectiveIcp::planes(const DepthBlocks& blocks) const {
  RASTRO_CHECK(blocks.width == width_ && blocks.height == height_, "blocks of this camera");
  std::vector<BlockPlane> planes(blocks.depth.size());
  for (int y = plane_reach; y + plane_reach < height_; ++y) {
    for (int x = plane_reach; x + plane_reach < width_; ++x) {
      const std::size_t center = static_cast<std::size_t>(y * width_ + x);
      const auto slope = inverse_depth_slope(blocks, x, y, options_);
      if (!slope) continue;
      // 1/z = A x + B y + C over the normalized image is the plane (A, B, C) . p = 1.
      const Eigen::Vector2f ray = rays_[center];
      const float a = slope->across / (0.5F * (rays_[center + 1].x() - rays_[center - 1].x()));
      const std::size_t row = static_cast<std::size_t>(width_);
      const float b = slope->down / (0.5F * (rays_[center + row].y() - rays_[center - row].y()));
      const Eigen::Vector3f plane(a, b, slope->mean - a * ray.x() - b * ray.y());
      const float length = plane.norm();
      // Cosine between the surface's normal and the viewing ray.
      if (!(length > 0.0F) || !(slope->mean > least_facing * length * ray.homogeneous().norm())) continue;
      planes[center] = {plane / length, 1.0F / length};
    }
  }
  return planes;
}

const BlockPlane* ProjectiveIcp::plane_at(const std::vector<BlockPlane>& reference,
                                          const Eigen::Vector3d& point) const {
  const auto pixel = camera_.project(point);
  if (!pixel) return nullptr;
  constexpr double middle = 0.5 * (block - 1);
  const double across = std::round((pixel->x() - middle) / block), down = std::round((pixel->y() - middle) / block);
  if (!(across >= 0.0 && down >= 0.0 && across < width_ && down < height_)) return nullptr;
  const BlockPlane& plane =
      reference[static_cast<std::size_t>(static_cast<int>(down) * width_ + static_cast<int>(across))];
  return plane.distance > 0.0F ? &plane : nullptr;
}

SurfaceFit ProjectiveIcp::compare(const std::vector<BlockPlane>& reference, const DepthBlocks& blocks,
                                  const SE3& reference_from_blocks, double reach_m, int step) const {
  RASTRO_CHECK(blocks.width == width_ && blocks.height == height_ && reference.size() == rays_.size(),
               "blocks of this camera");
  SurfaceFit fit;
  const Eigen::Matrix3d rotation = reference_from_blocks.rotation().matrix();
  const Eigen::Vector3d& translation = reference_from_blocks.translation();
  for (int y = step / 2; y < height_; y += step) {
    for (int x = step / 2; x < width_; x += step) {
      if (!(blocks.depth[static_cast<std::size_t>(y * width_ + x)] > 0.0F)) continue;
      const Eigen::Vector3d p = point_of(blocks, x, y);
      const Eigen::Vector3d p_in_reference = rotation * p + translation;
      const BlockPlane* plane = plane_at(reference, p_in_reference);
      if (!plane) continue;
      const Eigen::Vector3d normal = plane->normal.cast<double>();
      const double error = static_cast<double>(plane->distance) - normal.dot(p_in_reference);
      // Both depths have noise along their rays, which meet the plane at nearly this angle.
      const double facing = std::abs(normal.dot(p_in_reference)) / p_in_reference.norm();
      const double noise = facing * std::hypot(sigma(p.z()), sigma(p_in_reference.z()));
      const TukeyKernel kernel{reach_m + fitting_noises * noise};
      const double weight = kernel.weight(error * error) / (noise * noise);
      if (!(weight > 0.0)) continue;
      ++fit.compared;
      if (std::abs(error) < fitting_noises * noise) ++fit.fitting;
      const Eigen::Vector3d rotated = rotation.transpose() * normal;
      Vector6d jacobian;
      jacobian << rotated, p.cross(rotated);
      fit.information.noalias() += weight * jacobian * jacobian.transpose();
      fit.gradient.noalias() += weight * error * jacobian;
    }
  }
  return fit;
}

double ProjectiveIcp::overlap(const std::vector<BlockPlane>& reference, const DepthBlocks& blocks,
                              const SE3& reference_from_blocks, double reach_m) const {
  int measured = 0, seen = 0;
  for (int y = overlap_step / 2; y < height_; y += overlap_step) {
    for (int x = overlap_step / 2; x < width_; x += overlap_step) {
      if (!(blocks.depth[static_cast<std::size_t>(y * width_ + x)] > 0.0F)) continue;
      ++measured;
      const Eigen::Vector3d p = reference_from_blocks * point_of(blocks, x, y);
      const BlockPlane* plane = plane_at(reference, p);
      if (plane && std::abs(plane->normal.cast<double>().dot(p) - static_cast<double>(plane->distance)) < reach_m)
        ++seen;
    }
  }
  return measured > 0 ? static_cast<double>(seen) / measured : 0.0;
}

}  // namespace rastro
