// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/feature/orb.h"

namespace rastro {

/// The features of an image, indexed by position. "Pixel" below is a position in the undistorted image, which has the
/// camera's focal lengths and principal point but no distortion.
class FeatureGrid {
 public:
  /// `pixels`, `right_pixels` (x in the right camera; NaN: unknown): one per feature. A feature whose pixel is NaN is
  /// never found.
  FeatureGrid(const Camera& camera, std::shared_ptr<const Features> features, std::vector<Eigen::Vector2f> pixels,
              std::vector<float> right_pixels);

  /// The same features in another object.
  void share(std::shared_ptr<const Features> features) { features_ = std::move(features); }

  std::size_t size() const { return pixels_.size(); }
  const Eigen::Vector2f& pixel(std::size_t feature) const { return pixels_[feature]; }
  float right_pixel(std::size_t feature) const { return right_[feature]; }
  std::uint8_t level(std::size_t feature) const { return features_->levels[feature]; }
  const Descriptor& descriptor(std::size_t feature) const { return features_->descriptors[feature]; }

  /// Features within the square of half side `radius` around (x, y) whose level is in [min_level, max_level]; ascending
  /// within each cell of the grid, cells row by row.
  void find(float x, float y, float radius, int min_level, int max_level, std::vector<std::uint32_t>& found) const;
  /// Whether the position is inside the undistorted image's bounds.
  bool holds(float x, float y) const { return x >= min_x_ && x < max_x_ && y >= min_y_ && y < max_y_; }

 private:
  void find_bounds(const Camera& camera);
  void fill_cells();

  std::shared_ptr<const Features> features_;
  std::vector<Eigen::Vector2f> pixels_;
  std::vector<float> right_;
  float min_x_ = 0, max_x_ = 0, min_y_ = 0, max_y_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> cell_begin_;  ///< One per cell and one more, into cell_features_.
  std::vector<std::uint32_t> cell_features_;
};

}  // namespace rastro
