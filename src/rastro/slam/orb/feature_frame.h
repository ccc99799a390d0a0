// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// The features of a frame as tracking and mapping use them: undistorted, and found by place. "Pixel" below is a place
/// in the ideal picture, which has the camera's focal lengths and centre but no distortion.
class FeatureFrame {
 public:
  /// Features whose distortion cannot be undone get NaN and are never found.
  FeatureFrame(std::shared_ptr<const ImageFeatures> data, const Camera& camera, double baseline);

  /// The same as a keyframe.
  std::shared_ptr<const FeatureFrame> with_id(std::int64_t id) const;

  const ImageFeatures& data() const { return *data_; }
  const std::shared_ptr<const ImageFeatures>& shared_data() const { return data_; }
  std::size_t size() const { return pixels_.size(); }
  const Eigen::Vector2f& pixel(std::size_t feature) const { return pixels_[feature]; }
  /// x of the feature in the (ideal) right camera, from stereo or from depth; NaN: unknown.
  float right_pixel(std::size_t feature) const { return right_[feature]; }
  /// Normalised: (x/z, y/z).
  Eigen::Vector2d ray(std::size_t feature) const;
  double right_ray(std::size_t feature) const;
  /// In the camera frame; only where right_pixel() is known.
  Eigen::Vector3d point(std::size_t feature) const;
  std::uint8_t level(std::size_t feature) const { return data_->features.levels[feature]; }
  const Descriptor& descriptor(std::size_t feature) const { return data_->features.descriptors[feature]; }

  /// Features within the square of half side `radius` about (x, y) whose level is in [least, most]; ascending within
  /// each cell of the grid, cells row by row.
  void find(float x, float y, float radius, int least, int most, std::vector<std::uint32_t>& found) const;
  /// Inside the picture's ideal bounds?
  bool holds(float x, float y) const { return x >= min_x_ && x < max_x_ && y >= min_y_ && y < max_y_; }

 private:
  void build_grid(const Camera& camera);

  std::shared_ptr<const ImageFeatures> data_;
  double fx_, fy_, cx_, cy_, baseline_;
  std::vector<Eigen::Vector2f> pixels_;
  std::vector<float> right_;
  float min_x_ = 0, max_x_ = 0, min_y_ = 0, max_y_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> cell_begin_;  ///< One a cell and one more, into cell_features_.
  std::vector<std::uint32_t> cell_features_;
};

}  // namespace rastro
