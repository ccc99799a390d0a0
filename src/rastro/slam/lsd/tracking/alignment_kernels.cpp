// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/alignment_kernels.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/simd.h"

namespace rastro {
namespace {

// Every expression below has a twin in alignment_kernels_avx2.cpp that rounds in the same order.

struct PointProjection {
  float u, v;           ///< Normalized.
  float inverse_depth;  ///< Of the point in the image, times its depth in the reference.
  float pixel_x, pixel_y;
  bool inside;
};

PointProjection project_point(const AlignmentView& view, float x, float y, float inverse_depth) {
  const float *r = view.rotation, *t = view.translation;
  const float to_x = r[0] * x + r[1] * y + r[2] + t[0] * inverse_depth;
  const float to_y = r[3] * x + r[4] * y + r[5] + t[1] * inverse_depth;
  const float to_z = r[6] * x + r[7] * y + r[8] + t[2] * inverse_depth;
  PointProjection p;
  p.inverse_depth = 1.0F / to_z;
  p.u = to_x * p.inverse_depth;
  p.v = to_y * p.inverse_depth;
  p.pixel_x = view.fx * p.u + view.cx;
  p.pixel_y = view.fy * p.v + view.cy;
  p.inside =
      to_z > 0.0F && p.pixel_x >= 0.0F && p.pixel_x < view.last_x && p.pixel_y >= 0.0F && p.pixel_y < view.last_y;
  return p;
}

float sample_intensity(const AlignmentView& view, float x, float y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float fraction_x = x - static_cast<float>(column), fraction_y = y - static_cast<float>(row);
  const std::uint8_t *above = view.pixels + row * view.stride + column, *below = above + view.stride;
  const auto between = [&](const std::uint8_t* pixels) {
    const float left = pixels[0], right = pixels[1];
    return left + fraction_x * (right - left);
  };
  const float top = between(above), bottom = between(below);
  return top + fraction_y * (bottom - top);
}

void clear_point(AlignmentColumns& columns, int i) {
  for (auto& column : columns.column) column[i] = 0.0F;
  columns.weight[i] = 0.0F;
}

/// Derivatives of the intensity by (translation, rotation). Returns that by the inverse depth.
float jacobian(const AlignmentPoints& points, int point, const AlignmentView& view, const PointProjection& p,
               AlignmentColumns& columns, int i) {
  const auto k = static_cast<std::size_t>(point);
  const float *r = view.rotation, *t = view.translation, *turn = view.gradient_turn;
  const float x = points.x[k], y = points.y[k], inverse_depth = points.inverse_depth[k];
  const float a0 = (turn[0] * points.gradient_x[k] + turn[1] * points.gradient_y[k]) * p.inverse_depth;
  const float a1 = (turn[2] * points.gradient_x[k] + turn[3] * points.gradient_y[k]) * p.inverse_depth;
  const float a2 = 0.0F - (a0 * p.u + a1 * p.v);
  const float b0 = r[0] * a0 + r[3] * a1 + r[6] * a2;
  const float b1 = r[1] * a0 + r[4] * a1 + r[7] * a2;
  const float b2 = r[2] * a0 + r[5] * a1 + r[8] * a2;
  columns.column[0][i] = inverse_depth * b0;
  columns.column[1][i] = inverse_depth * b1;
  columns.column[2][i] = inverse_depth * b2;
  columns.column[3][i] = y * b2 - b1;
  columns.column[4][i] = b0 - x * b2;
  columns.column[5][i] = x * b1 - y * b0;
  return a0 * t[0] + a1 * t[1] + a2 * t[2];
}

/// Residual, weight and cost of a point with this intensity in the image.
void weigh(float residual, float by_inverse_depth, float depth_variance, const AlignmentView& view,
           AlignmentColumns& columns, int i) {
  const float precision = 1.0F / (view.noise_variance + by_inverse_depth * by_inverse_depth * depth_variance);
  const float squared = residual * residual * precision;
  const float error = std::sqrt(squared);
  columns.column[8][i] = residual;
  columns.weight[i] = std::min(1.0F, view.huber_width / error) * precision;
  const float capped = std::min(error, view.huber_width);
  columns.cost_lanes[i % 8] += capped * (error + error - capped);
  columns.inliers += squared < 9.0F;
}

void linearize_plain(const AlignmentPoints& points, int begin, int end, const AlignmentView& view,
                     AlignmentColumns& columns) {
  columns.points = (end - begin + 7) / 8 * 8;
  columns.inside = columns.used = columns.inliers = 0;
  std::fill(columns.cost_lanes, columns.cost_lanes + 8, 0.0F);
  for (int i = 0; i < columns.points; ++i) {
    clear_point(columns, i);
    const auto k = static_cast<std::size_t>(begin) + static_cast<std::size_t>(i);
    const PointProjection p = project_point(view, points.x[k], points.y[k], points.inverse_depth[k]);
    if (!p.inside) continue;
    ++columns.inside;
    const float intensity = sample_intensity(view, p.pixel_x, p.pixel_y);
    if (!(intensity > view.darkest && intensity < view.brightest)) continue;
    ++columns.used;
    const float by_inverse_depth = jacobian(points, begin + i, view, p, columns, i);
    columns.column[6][i] = 0.0F - points.intensity[k];
    columns.column[7][i] = -1.0F;
    weigh(intensity - view.gain * points.intensity[k] - view.offset, by_inverse_depth, points.variance[k], view,
          columns, i);
  }
}

/// Products of column `row` with itself and the later ones.
void accumulate_row(const AlignmentColumns& columns, int row, double* out) {
  float lanes[alignment_columns][8] = {};
  for (int i = 0; i < columns.points; i += 8) {
    float weighted[8];
    for (int lane = 0; lane < 8; ++lane) weighted[lane] = columns.weight[i + lane] * columns.column[row][i + lane];
    for (int j = row; j < alignment_columns; ++j) {
      for (int lane = 0; lane < 8; ++lane) lanes[j][lane] += weighted[lane] * columns.column[j][i + lane];
    }
  }
  for (int j = row; j < alignment_columns; ++j) {
    double sum = 0.0;
    for (const float lane : lanes[j]) sum += static_cast<double>(lane);
    *out++ = sum;
  }
}

void accumulate_plain(const AlignmentColumns& columns, AlignmentSums& sums) {
  double* out = sums.products.data();
  for (int row = 0; row < alignment_columns; ++row) {
    accumulate_row(columns, row, out);
    out += alignment_columns - row;
  }
  sums.cost = 0.0;
  for (const float lane : columns.cost_lanes) sums.cost += static_cast<double>(lane);
  sums.inside = columns.inside;
  sums.used = columns.used;
  sums.inliers = columns.inliers;
}

}  // namespace

AlignmentView alignment_view(const PaddedImage& image, const LevelCamera& camera, const SE3& image_from_reference,
                             double gain, double offset, const PhotometricNoise& noise) {
  const auto narrow = [](double value) { return static_cast<float>(value); };
  AlignmentView view;
  view.pixels = image.row(0);
  view.stride = static_cast<int>(image.stride());
  view.last_x = static_cast<float>(image.width() - 1);
  view.last_y = static_cast<float>(image.height() - 1);
  const Eigen::Matrix3d rotation = image_from_reference.rotation().matrix();
  for (int i = 0; i < 9; ++i) view.rotation[i] = narrow(rotation(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) view.translation[i] = narrow(image_from_reference.translation()[i]);
  view.fx = narrow(camera.fx), view.fy = narrow(camera.fy);
  view.cx = narrow(camera.cx), view.cy = narrow(camera.cy);
  // Only the rotation about the optical axis: scale and shear differ from point to point, and less.
  const double cosine = rotation(0, 0) + rotation(1, 1), sine = rotation(1, 0) - rotation(0, 1);
  const double scale = gain / std::max(1e-12, std::hypot(cosine, sine));
  view.gradient_turn[0] = view.gradient_turn[3] = narrow(scale * cosine);
  view.gradient_turn[1] = narrow(-scale * sine), view.gradient_turn[2] = narrow(scale * sine);
  view.gain = narrow(gain), view.offset = narrow(offset);
  view.noise_variance = narrow((1.0 + gain * gain) * noise.intensity_sigma * noise.intensity_sigma);
  view.huber_width = narrow(noise.huber_width);
  view.darkest = narrow(noise.darkest), view.brightest = narrow(noise.brightest);
  return view;
}

AlignmentSums& AlignmentSums::operator+=(const AlignmentSums& other) {
  for (std::size_t i = 0; i < products.size(); ++i) products[i] += other.products[i];
  cost += other.cost;
  inside += other.inside;
  used += other.used;
  inliers += other.inliers;
  return *this;
}

const AlignmentKernels& alignment_kernels_plain() {
  static const AlignmentKernels kernels{linearize_plain, accumulate_plain};
  return kernels;
}

const AlignmentKernels& alignment_kernels() {
  return simd_level() == SimdLevel::avx2 ? alignment_kernels_avx2() : alignment_kernels_plain();
}

}  // namespace rastro
