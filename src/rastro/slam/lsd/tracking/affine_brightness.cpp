// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/affine_brightness.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

/// Moments of (intensity in the reference, intensity in the image).
struct IntensityMoments {
  double count = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero(), squares = Eigen::Vector2d::Zero();

  void add(const AlignmentColumns& columns) {
    for (int i = 0; i < columns.points; ++i) {
      if (columns.weight[i] == 0.0F) continue;
      const double reference = -static_cast<double>(columns.column[6][i]);
      const Eigen::Vector2d pair(reference, static_cast<double>(columns.column[8][i]) + reference);
      sum += pair, squares += pair.cwiseAbs2(), count += 1.0;
    }
  }
};

}  // namespace

AffineBrightness matched_brightness(const AlignmentPoints& points, const PaddedImage& image,
                                    const SE3& image_from_reference, const PhotometricNoise& noise) {
  constexpr double fewest = 8.0;
  const AlignmentView view = alignment_view(image, points.camera, image_from_reference, 1.0, 0.0, noise);
  AlignmentColumns columns;
  IntensityMoments moments;
  for (int begin = 0; begin < points.count; begin += alignment_chunk) {
    alignment_kernels().linearize(points, begin, std::min(begin + alignment_chunk, points.count), view, columns);
    moments.add(columns);
  }
  if (moments.count < fewest) return {};
  const Eigen::Vector2d mean = moments.sum / moments.count;
  const Eigen::Vector2d variance = (moments.squares / moments.count - mean.cwiseAbs2()).cwiseMax(1.0);
  const double gain = std::clamp(std::sqrt(variance[1] / variance[0]), 0.2, 5.0);
  return {gain, mean[1] - gain * mean[0]};
}

}  // namespace rastro
