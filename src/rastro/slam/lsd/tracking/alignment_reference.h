// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/pyramid.h"
#include "rastro/slam/lsd/inverse_depth_map.h"
#include "rastro/slam/lsd/tracking/alignment_pixels.h"
#include "rastro/slam/lsd/tracking/inverse_depth_pyramid.h"

namespace rastro {

/// Enough for the vectors that read beside a sampled pixel, and for the pyramid's own filter.
constexpr int alignment_padding = 32;

/// The image pyramid that both sides of a direct alignment are made from.
Pyramid alignment_pyramid(GrayView image, int levels, TaskPool* pool = nullptr);

/// Pinhole of one level of a pyramid, whose pixel (x, y) lies at (x, y) * 2^level of level 0.
struct LevelCamera {
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< Pixels of the level.

  LevelCamera() = default;
  LevelCamera(const Camera& camera, int level);
};

/// The points of one level as arrays, one element per point, in tiles of 32 x 32 pixels: neighbors in the arrays are
/// neighbors in the image. The arrays end on a multiple of eight; elements behind `count` are NaN and project nowhere.
struct AlignmentPoints {
  int count = 0;
  LevelCamera camera;
  float mean_inverse_depth = 0.0F;
  /// By which share motion from depths with these errors is too short, as any regression on noisy values attenuates
  /// (Fuller 1987, "Measurement Error Models", section 1.1): sum of the variances / sum of the squared inverse depths.
  float attenuation = 0.0F;
  std::vector<float> x, y;                    ///< Normalized ray (x, y, 1) in the reference camera.
  std::vector<float> inverse_depth;           ///< Inverse of the map's unit.
  std::vector<float> variance;                ///< Of the inverse depth.
  std::vector<float> intensity;               ///< Less mid_intensity.
  std::vector<float> gradient_x, gradient_y;  ///< Of the intensity by the normalized ray: levels per pixel * f.

  /// Intensities are kept relative to this one, so that gain and offset are hardly correlated.
  static constexpr float mid_intensity = 128.0F;
};

struct AlignmentReferenceOptions {
  int levels = 5;
  /// Weaker pixels hardly constrain the motion. Intensity levels per pixel of the level.
  double min_gradient = 3.0;
  /// Most points of a level; beyond that each tile keeps its share of those with the strongest gradients. 0: no limit.
  int max_points = 0;
};

/// A keyframe prepared for direct alignment: on each level the pixels with known inverse depth and sufficient gradient
/// (Engel et al. 2014, section 3.3).
class AlignmentReference {
 public:
  /// `depth` has the size of the image's level 0; `camera` is a pinhole without distortion of that size. Call again
  /// after the inverse depth has changed.
  void build(const Pyramid& image, const InverseDepthMap& depth, const Camera& camera,
             const AlignmentReferenceOptions& options = {});
  /// The same points from what is at hand: the pixels with gradient and the inverse depth of each level, of the levels
  /// after the finest in `coarser`. Sets no depth().
  void set_points(const Pyramid& image, const std::vector<AlignmentPixels>& pixels, const InverseDepthMap& finest,
                  std::span<const InverseDepthMap> coarser, const Camera& camera, int max_points);

  int levels() const { return static_cast<int>(points_.size()); }
  const AlignmentPoints& level(int index) const { return points_[static_cast<std::size_t>(index)]; }
  /// Inverse depth on each level, for the other side of a similarity alignment; as of the last build().
  const std::vector<InverseDepthMap>& depth() const { return depth_; }

 private:
  std::vector<AlignmentPoints> points_;
  std::vector<InverseDepthMap> depth_;
};

}  // namespace rastro
