// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/backend/feature_grid.h"
#include "rastro/camera/camera.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// The features of a frame for tracking and mapping: undistorted and indexed by position. "Pixel" is defined in
/// FeatureGrid.
class FeatureFrame {
 public:
  /// Features whose distortion cannot be inverted get NaN and are never matched.
  FeatureFrame(std::shared_ptr<const ImageFeatures> data, const Camera& camera, double baseline);

  /// The same features with the id of a keyframe.
  std::shared_ptr<const FeatureFrame> with_id(std::int64_t id) const;

  const ImageFeatures& data() const { return *data_; }
  const std::shared_ptr<const ImageFeatures>& shared_data() const { return data_; }
  /// For guided search.
  const FeatureGrid& grid() const { return grid_; }
  std::size_t size() const { return grid_.size(); }
  const Eigen::Vector2f& pixel(std::size_t feature) const { return grid_.pixel(feature); }
  /// x of the feature in the (undistorted) right camera, from stereo or from depth; NaN: unknown.
  float right_pixel(std::size_t feature) const { return grid_.right_pixel(feature); }
  /// Normalized: (x/z, y/z).
  Eigen::Vector2d ray(std::size_t feature) const;
  double right_ray(std::size_t feature) const;
  /// In the camera frame; only where right_pixel() is known.
  Eigen::Vector3d point(std::size_t feature) const;
  std::uint8_t level(std::size_t feature) const { return data_->features.levels[feature]; }
  const Descriptor& descriptor(std::size_t feature) const { return data_->features.descriptors[feature]; }

 private:
  FeatureGrid make_grid(const Camera& camera, double baseline) const;

  std::shared_ptr<const ImageFeatures> data_;
  double fx_, fy_, cx_, cy_;
  FeatureGrid grid_;
};

}  // namespace rastro
