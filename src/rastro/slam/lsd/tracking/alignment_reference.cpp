// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/alignment_reference.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rastro {
namespace {

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

void fill_points(AlignmentPoints& points, const std::vector<AlignmentPixel>& pixels, const PaddedImage& image,
                 const InverseDepthMap& depth) {
  resize_points(points, pixels.size());
  const auto cx = static_cast<float>(points.camera.cx), cy = static_cast<float>(points.camera.cy);
  const auto fx = static_cast<float>(points.camera.fx), fy = static_cast<float>(points.camera.fy);
  const float per_fx = 1.0F / fx, per_fy = 1.0F / fy;
  double sum = 0.0, squares = 0.0, variances = 0.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const AlignmentPixel& pixel = pixels[i];
    points.x[i] = (static_cast<float>(pixel.x) - cx) * per_fx;
    points.y[i] = (static_cast<float>(pixel.y) - cy) * per_fy;
    points.inverse_depth[i] = depth.mean.at(pixel.x, pixel.y);
    points.variance[i] = depth.variance.at(pixel.x, pixel.y);
    points.intensity[i] = static_cast<float>(image.row(pixel.y)[pixel.x]) - AlignmentPoints::mid_intensity;
    points.gradient_x[i] = 0.5F * static_cast<float>(pixel.twice_gradient_x) * fx;
    points.gradient_y[i] = 0.5F * static_cast<float>(pixel.twice_gradient_y) * fy;
    const auto inverse_depth = static_cast<double>(points.inverse_depth[i]);
    sum += inverse_depth;
    squares += inverse_depth * inverse_depth;
    variances += static_cast<double>(points.variance[i]);
  }
  points.attenuation = squares > 0.0 ? static_cast<float>(variances / squares) : 0.0F;
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
  const int levels = std::min(options.levels, image.levels());
  depth_ = inverse_depth_pyramid(depth, levels);
  set_points(image, alignment_pixels(image, levels, options.min_gradient), depth_.front(), std::span(depth_).subspan(1),
             camera, options.max_points);
}

void AlignmentReference::set_points(const Pyramid& image, const std::vector<AlignmentPixels>& pixels,
                                    const InverseDepthMap& finest, std::span<const InverseDepthMap> coarser,
                                    const Camera& camera, int max_points) {
  RASTRO_CHECK(camera.distortion == Distortion::none, "images of a direct alignment are undistorted");
  RASTRO_CHECK(finest.width() == image.level(0).width() && finest.height() == image.level(0).height(),
               "an inverse depth for every pixel");
  points_.resize(pixels.size());
  for (std::size_t level = 0; level < pixels.size(); ++level) {
    const int index = static_cast<int>(level);
    const InverseDepthMap& depth = level == 0 ? finest : coarser[level - 1];
    points_[level].camera = LevelCamera(camera, index);
    fill_points(points_[level], pixels[level].known_ones(depth, static_cast<std::size_t>(max_points)),
                image.level(index), depth);
  }
}

}  // namespace rastro
