// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/alignment_reference.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace rastro {
namespace {

constexpr int alignment_tile_px = 32;

struct SelectedPixel {
  int x, y;
  float gradient_x, gradient_y;  ///< Central differences, levels per pixel.

  float squared_gradient() const { return gradient_x * gradient_x + gradient_y * gradient_y; }
};

/// Appends the pixels of a tile with known inverse depth and sufficient gradient, row by row.
void select_tile(const PaddedImage& image, const InverseDepthMap& depth, int left, int top, double min_gradient,
                 std::vector<SelectedPixel>& selected) {
  const auto least = static_cast<float>(min_gradient * min_gradient);
  // The outermost pixels have no gradient across the border.
  const int x_end = std::min(left + alignment_tile_px, image.width() - 1),
            y_end = std::min(top + alignment_tile_px, image.height() - 1);
  for (int y = std::max(top, 1); y < y_end; ++y) {
    const std::uint8_t *above = image.row(y - 1), *row = image.row(y), *below = image.row(y + 1);
    const float* variance = depth.variance.row(y);
    for (int x = std::max(left, 1); x < x_end; ++x) {
      if (!(variance[x] > 0.0F)) continue;
      const SelectedPixel pixel{x, y, 0.5F * static_cast<float>(row[x + 1] - row[x - 1]),
                                0.5F * static_cast<float>(below[x] - above[x])};
      if (pixel.squared_gradient() >= least) selected.push_back(pixel);
    }
  }
}

/// Keeps the `quota` strongest of those from `begin` on, in their order; among equal ones the first.
void keep_strongest(std::vector<SelectedPixel>& pixels, std::size_t begin, std::size_t quota) {
  if (pixels.size() - begin <= quota) return;
  const auto first = pixels.begin() + static_cast<std::ptrdiff_t>(begin);
  std::vector<float> strengths(pixels.size() - begin);
  std::transform(first, pixels.end(), strengths.begin(), [](const auto& pixel) { return pixel.squared_gradient(); });
  const auto weakest_kept = strengths.begin() + static_cast<std::ptrdiff_t>(quota);
  std::nth_element(strengths.begin(), weakest_kept, strengths.end(), std::greater<>());
  const float limit = *weakest_kept;
  // All above the limit are kept, and of those at it as many as are still missing.
  auto missing = static_cast<std::ptrdiff_t>(quota) -
                 std::count_if(strengths.begin(), weakest_kept, [&](float strength) { return strength > limit; });
  pixels.erase(std::remove_if(first, pixels.end(),
                              [&](const SelectedPixel& pixel) {
                                const float strength = pixel.squared_gradient();
                                return strength < limit || (strength == limit && missing-- <= 0);
                              }),
               pixels.end());
}

/// Every tile keeps the same share, rounded so that the level has `max_points` in the end.
std::vector<SelectedPixel> thinned_pixels(const std::vector<SelectedPixel>& pixels,
                                          const std::vector<std::size_t>& tile_ends, std::size_t max_points) {
  std::vector<SelectedPixel> kept;
  kept.reserve(max_points + pixels.size() / tile_ends.size());
  std::size_t begin = 0;
  for (const std::size_t end : tile_ends) {
    const std::size_t first = kept.size();
    kept.insert(kept.end(), pixels.begin() + static_cast<std::ptrdiff_t>(begin),
                pixels.begin() + static_cast<std::ptrdiff_t>(end));
    keep_strongest(kept, first, end * max_points / pixels.size() - begin * max_points / pixels.size());
    begin = end;
  }
  return kept;
}

std::vector<SelectedPixel> select_pixels(const PaddedImage& image, const InverseDepthMap& depth,
                                         const AlignmentReferenceOptions& options) {
  std::vector<SelectedPixel> pixels;
  std::vector<std::size_t> tile_ends;
  for (int top = 0; top < image.height(); top += alignment_tile_px) {
    for (int left = 0; left < image.width(); left += alignment_tile_px) {
      select_tile(image, depth, left, top, options.min_gradient, pixels);
      tile_ends.push_back(pixels.size());
    }
  }
  const auto max_points = static_cast<std::size_t>(options.max_points);
  return max_points == 0 || pixels.size() <= max_points ? pixels : thinned_pixels(pixels, tile_ends, max_points);
}

/// Elements behind `count` are NaN: they project nowhere.
void resize_points(AlignmentPoints& points, std::size_t count) {
  points.count = static_cast<int>(count);
  const std::size_t whole = (count + 7) / 8 * 8;
  for (auto* values : {&points.x, &points.y, &points.inverse_depth, &points.variance, &points.intensity,
                       &points.gradient_x, &points.gradient_y}) {
    values->resize(whole);
    std::fill(values->begin() + static_cast<std::ptrdiff_t>(count), values->end(),
              std::numeric_limits<float>::quiet_NaN());
  }
}

void fill_points(AlignmentPoints& points, const std::vector<SelectedPixel>& pixels, const PaddedImage& image,
                 const InverseDepthMap& depth) {
  resize_points(points, pixels.size());
  const auto cx = static_cast<float>(points.camera.cx), cy = static_cast<float>(points.camera.cy);
  const auto fx = static_cast<float>(points.camera.fx), fy = static_cast<float>(points.camera.fy);
  const float per_fx = 1.0F / fx, per_fy = 1.0F / fy;
  double sum = 0.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const SelectedPixel& pixel = pixels[i];
    points.x[i] = (static_cast<float>(pixel.x) - cx) * per_fx;
    points.y[i] = (static_cast<float>(pixel.y) - cy) * per_fy;
    points.inverse_depth[i] = depth.mean.at(pixel.x, pixel.y);
    points.variance[i] = depth.variance.at(pixel.x, pixel.y);
    points.intensity[i] = static_cast<float>(image.row(pixel.y)[pixel.x]) - AlignmentPoints::mid_intensity;
    points.gradient_x[i] = pixel.gradient_x * fx;
    points.gradient_y[i] = pixel.gradient_y * fy;
    sum += static_cast<double>(points.inverse_depth[i]);
  }
  points.mean_inverse_depth = pixels.empty() ? 0.0F : static_cast<float>(sum / static_cast<double>(pixels.size()));
}

}  // namespace

Pyramid alignment_pyramid(GrayView image, int levels, TaskPool* pool) {
  Pyramid pyramid;
  pyramid.build(image, levels, alignment_padding, pool);
  return pyramid;
}

LevelCamera::LevelCamera(const Camera& camera, int level) {
  const double scale = std::ldexp(1.0, -level);
  fx = camera.fx * scale, fy = camera.fy * scale;
  cx = camera.cx * scale, cy = camera.cy * scale;
}

void AlignmentReference::build(const Pyramid& image, const InverseDepthMap& depth, const Camera& camera,
                               const AlignmentReferenceOptions& options) {
  RASTRO_CHECK(camera.distortion == Distortion::none, "images of a direct alignment are undistorted");
  RASTRO_CHECK(depth.width() == image.level(0).width() && depth.height() == image.level(0).height(),
               "an inverse depth for every pixel");
  const int levels = std::min(options.levels, image.levels());
  depth_ = inverse_depth_pyramid(depth, levels);
  points_.resize(static_cast<std::size_t>(levels));
  for (int level = 0; level < levels; ++level) {
    AlignmentPoints& points = points_[static_cast<std::size_t>(level)];
    const InverseDepthMap& level_depth = depth_[static_cast<std::size_t>(level)];
    points.camera = LevelCamera(camera, level);
    fill_points(points, select_pixels(image.level(level), level_depth, options), image.level(level), level_depth);
  }
}

}  // namespace rastro
