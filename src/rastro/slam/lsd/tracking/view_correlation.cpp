// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/view_correlation.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace rastro {
namespace {

/// Pearson's coefficient of a chunk; nullopt where too few points are compared, or all are alike.
std::optional<double> correlation_of(const AlignmentColumns& columns) {
  constexpr double fewest = alignment_chunk / 4.0, least_variance = 1.0;
  double count = 0.0, sum_a = 0.0, sum_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (int i = 0; i < columns.points; ++i) {
    if (columns.weight[i] == 0.0F) continue;
    const double a = -static_cast<double>(columns.column[6][i]);     // in the reference
    const double b = static_cast<double>(columns.column[8][i]) + a;  // in the image
    count += 1.0, sum_a += a, sum_b += b, aa += a * a, bb += b * b, ab += a * b;
  }
  if (count < fewest) return std::nullopt;
  const double variance_a = aa / count - sum_a * sum_a / (count * count);
  const double variance_b = bb / count - sum_b * sum_b / (count * count);
  if (variance_a < least_variance) return std::nullopt;
  if (variance_b < least_variance) return 0.0;
  return (ab / count - sum_a * sum_b / (count * count)) / std::sqrt(variance_a * variance_b);
}

}  // namespace

double correlated_share(const AlignmentPoints& points, const PaddedImage& image, const SE3& image_from_reference,
                        const PhotometricNoise& noise, double min_correlation) {
  const AlignmentView view = alignment_view(image, points.camera, image_from_reference, 1.0, 0.0, noise);
  AlignmentColumns columns;
  int judged = 0, correlated = 0;
  for (int begin = 0; begin < points.count; begin += alignment_chunk) {
    alignment_kernels().linearize(points, begin, std::min(begin + alignment_chunk, points.count), view, columns);
    const auto correlation = correlation_of(columns);
    if (!correlation) continue;
    ++judged;
    correlated += *correlation >= min_correlation ? 1 : 0;
  }
  return judged > 0 ? static_cast<double>(correlated) / judged : 0.0;
}

}  // namespace rastro
