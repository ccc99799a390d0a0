// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/rotation_search.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

/// Of a pixel (x, y) of `a` with (x + dx, y + dy) of `b`.
double correlation_at(GrayView a, GrayView b, int dx, int dy) {
  double n = 0.0, sum_a = 0.0, sum_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (int y = std::max(0, -dy); y < std::min(a.height, b.height - dy); ++y) {
    std::int64_t row_a = 0, row_b = 0, row_aa = 0, row_bb = 0, row_ab = 0;
    const std::uint8_t *of_a = a.row(y), *of_b = b.row(y + dy) + dx;
    const int first = std::max(0, -dx), end = std::min(a.width, b.width - dx);
    for (int x = first; x < end; ++x) {
      row_a += of_a[x], row_b += of_b[x];
      row_aa += of_a[x] * of_a[x], row_bb += of_b[x] * of_b[x], row_ab += of_a[x] * of_b[x];
    }
    n += end - first;
    sum_a += static_cast<double>(row_a), sum_b += static_cast<double>(row_b);
    aa += static_cast<double>(row_aa), bb += static_cast<double>(row_bb), ab += static_cast<double>(row_ab);
  }
  const double variances = (aa - sum_a * sum_a / n) * (bb - sum_b * sum_b / n);
  return variances > 0.0 ? (ab - sum_a * sum_b / n) / std::sqrt(variances) : -1.0;
}

}  // namespace

RotationGuess find_rotation(GrayView a, GrayView b, const LevelCamera& camera) {
  RotationGuess best;
  int best_dx = 0, best_dy = 0;
  for (int dy = -a.height / 2; dy <= a.height / 2; ++dy)
    for (int dx = -a.width / 2; dx <= a.width / 2; ++dx) {
      const double correlation = correlation_at(a, b, dx, dy);
      if (correlation > best.correlation) best.correlation = correlation, best_dx = dx, best_dy = dy;
    }
  // The pixel in the middle of a is seen there in b.
  const Eigen::Vector3d in_a = Eigen::Vector3d::UnitZ(), in_b(best_dx / camera.fx, best_dy / camera.fy, 1.0);
  const Eigen::Quaterniond rotation = Eigen::Quaterniond::FromTwoVectors(in_a, in_b);
  best.b_from_a = SO3(rotation);
  return best;
}

}  // namespace rastro
