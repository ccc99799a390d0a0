// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"
#include "rastro/slam/lsd/refinement/photometric_bundle.h"

namespace rastro {

/// Pixels around a point that are compared with it, itself included.
constexpr std::size_t photometric_pattern_size = 7;

/// One pixel of a point's pattern as another keyframe sees it.
struct PhotometricSample {
  std::size_t point = 0;
  Eigen::Vector2d ray;        ///< In the host.
  Eigen::Vector3d direction;  ///< In the target, times the inverse depth there.
  double host = 0.0, target = 0.0;
  double squared_gradient = 0.0;  ///< Of the host's intensity.
  Eigen::Vector2d gradient;       ///< Of the target's.
};

/// Of the intensity at each pixel of a point's pattern; nullopt where the keyframe's mask leaves out one of them.
std::optional<std::array<double, photometric_pattern_size>> squared_gradients_around(const PhotometricKeyframe& host,
                                                                                     const PhotometricPoint& point);

/// Where points of `host` that `target` sees lie in it, with intensities. All outlive this.
class PhotometricSampler {
 public:
  PhotometricSampler(const PhotometricKeyframe& host, const PhotometricKeyframe& target, const Camera& camera);

  /// Appends the samples of a point, all of its pattern or none: where one is out of view, or masked in host or target.
  void add(std::size_t index, std::vector<PhotometricSample>& samples) const;

 private:
  std::optional<PhotometricSample> sample_of(std::size_t index, int x, int y) const;

  const PhotometricKeyframe& host_;
  const PhotometricKeyframe& target_;
  const Camera& camera_;
  SE3 target_from_host_;
  Eigen::Matrix3d rotation_;
};

/// Intensity in the target = gain * intensity in the host + offset.
struct PairBrightness {
  double gain = 1.0, offset = 0.0;
  double residual(const PhotometricSample& sample) const { return sample.target - gain * sample.host - offset; }
};

/// That fits the samples, in two rounds: the second without outliers. None of few samples.
PairBrightness brightness_of(const std::vector<PhotometricSample>& samples, double outlier);

}  // namespace rastro
