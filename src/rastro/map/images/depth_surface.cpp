// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/depth_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int block_px = 4;
constexpr int fewest_in_block = 6;
constexpr int most_missing_beside = 3;  ///< Of the eight neighbors: more are the border of a hole.

struct Block {
  Vector3f mean = Vector3f::Zero();
  Vector3f normal = Vector3f::Zero();
  bool valid = false;
};

/// Extracts the samples of one image.
class SampleExtraction {
 public:
  SampleExtraction(const UnpackedImages& images, const RayTable& rays, const SurfaceOptions& options)
      : depth_(images.depth),
        color_(images.color),
        rays_(rays),
        options_(options),
        columns_(depth_.width() / block_px),
        rows_(depth_.height() / block_px),
        blocks_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
        flattest_(static_cast<float>(std::cos(options.grazing_deg * std::numbers::pi / 180.0))) {
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) find_mean(column, row);
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) find_normal(column, row);
  }

  std::vector<SurfaceSample> samples() const {
    std::vector<SurfaceSample> found;
    const int half = options_.stride / 2;
    for (int y = std::max(1, half); y + 1 < depth_.height(); y += options_.stride)
      for (int x = std::max(1, half); x + 1 < depth_.width(); x += options_.stride) add(x, y, found);
    return found;
  }

 private:
  bool is_measured(float z) const {
    return z >= static_cast<float>(options_.min_depth_m) && z <= static_cast<float>(options_.max_depth_m);
  }
  float sigma(float z) const {
    return static_cast<float>(options_.depth_sigma_m + options_.depth_sigma_per_m2 * static_cast<double>(z) * z);
  }
  /// Neighboring depths of one surface differ by less, including noise and slope.
  float jump(float z) const { return 3.0F * sigma(z) + 0.01F * z; }
  Vector3f point(int x, int y, float z) const {
    const Vector2f& ray = rays_.at(x, y);
    return {ray.x() * z, ray.y() * z, z};
  }
  const Block* block(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return nullptr;
    const Block& found =
        blocks_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)];
    return found.valid ? &found : nullptr;
  }

  void find_mean(int column, int row) {
    Block& found =
        blocks_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)];
    float nearest = std::numeric_limits<float>::max(), farthest = 0.0F;
    int count = 0;
    for (int y = row * block_px; y < (row + 1) * block_px; ++y) {
      for (int x = column * block_px; x < (column + 1) * block_px; ++x) {
        const float z = depth_.at(x, y);
        if (!is_measured(z)) continue;
        nearest = std::min(nearest, z), farthest = std::max(farthest, z);
        found.mean += point(x, y, z);
        ++count;
      }
    }
    found.mean /= static_cast<float>(std::max(1, count));
    found.valid = count >= fewest_in_block && farthest - nearest < 2.0F * jump(nearest) && found.mean.allFinite();
  }

  /// From one side of the block to the other, or to the block itself if a side is missing.
  Vector3f tangent(const Block& middle, int column, int row, int dx, int dy) const {
    // Noise grows with the distance, and so does the size of a block in meters: distant planes are fitted over more
    // blocks.
    const int reach = 1 + static_cast<int>(middle.mean.z() / 1.5F);
    const Block* after = block(column + reach * dx, row + reach * dy);
    const Block* before = block(column - reach * dx, row - reach * dy);
    const float limit = static_cast<float>(reach * block_px) * 0.5F * jump(middle.mean.z());
    const auto is_near = [&](const Block* other) {
      return other != nullptr && std::abs(other->mean.z() - middle.mean.z()) < limit;
    };
    const Vector3f& end = is_near(after) ? after->mean : middle.mean;
    const Vector3f& begin = is_near(before) ? before->mean : middle.mean;
    return end - begin;
  }

  void find_normal(int column, int row) {
    const Block* middle = block(column, row);
    if (middle == nullptr) return;
    const Vector3f normal = tangent(*middle, column, row, 1, 0).cross(tangent(*middle, column, row, 0, 1));
    const float length = normal.norm();
    if (!(length > 1e-12F)) return;
    const float side = normal.dot(middle->mean) > 0.0F ? -1.0F : 1.0F;
    blocks_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)]
        .normal = normal * (side / length);
  }

  bool is_edge(int x, int y, float z) const {
    const float limit = jump(z);
    int missing = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      const float* row = depth_.row(y + dy) + x;
      for (int dx = -1; dx <= 1; ++dx) {
        if (row[dx] <= 0.0F) {
          ++missing;
        } else if (std::abs(row[dx] - z) > limit) {
          return true;
        }
      }
    }
    return missing > most_missing_beside;
  }

  void add(int x, int y, std::vector<SurfaceSample>& found) const {
    const float z = depth_.at(x, y);
    if (!is_measured(z) || is_edge(x, y, z)) return;
    SurfaceSample sample;
    sample.point_in_camera = point(x, y, z);
    if (!sample.point_in_camera.allFinite()) return;
    sample.sigma = sigma(z);
    if (const Block* around = block(x / block_px, y / block_px)) sample.normal_in_camera = around->normal;
    const bool has_normal = !sample.normal_in_camera.isZero();
    if (has_normal && -sample.normal_in_camera.dot(sample.point_in_camera.normalized()) < flattest_) return;
    const std::uint8_t* rgb = color_.rgb.row(y) + 3 * static_cast<std::ptrdiff_t>(x);
    sample.color = {rgb[0], rgb[1], rgb[2]};
    found.push_back(sample);
  }

  const DepthImage& depth_;
  const ColorImage& color_;
  const RayTable& rays_;
  const SurfaceOptions& options_;
  int columns_, rows_;
  std::vector<Block> blocks_;
  float flattest_;
};

}  // namespace

RayTable::RayTable(const Camera& camera, int width, int height) : width_(width), height_(height) {
  rays_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  constexpr float nowhere = std::numeric_limits<float>::quiet_NaN();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto ray = camera.unproject({x, y});
      rays_.push_back(ray ? ray->cast<float>().eval() : Vector2f(nowhere, nowhere));
    }
  }
}

std::vector<SurfaceSample> surface_samples(const UnpackedImages& images, const RayTable& rays,
                                           const SurfaceOptions& options) {
  RASTRO_CHECK(options.stride >= 1, "a stride is at least one pixel");
  RASTRO_CHECK(rays.width() == images.depth.width() && rays.height() == images.depth.height(),
               "rays and images are of one size");
  return SampleExtraction(images, rays, options).samples();
}

}  // namespace rastro
