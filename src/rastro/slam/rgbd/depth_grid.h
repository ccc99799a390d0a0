// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/map/keyframe/rgbd_keyframe.h"
#include "rastro/math/se3.h"

namespace rastro {

/// sigma(z) = constant + per_m2 * z^2, metres.
struct DepthNoise {
  double constant_m = 0.001, per_m2 = 0.002;
  double sigma(double depth_m) const { return constant_m + per_m2 * depth_m * depth_m; }
};

/// A depth picture of which few pixels are kept, for telling whether two views contradict each other. The same from a
/// frame as from its packed pictures.
class DepthGrid {
 public:
  static constexpr int step_px = 4;

  DepthGrid() = default;
  explicit DepthGrid(const DepthImage& depth);
  int width() const { return width_; }
  int height() const { return height_; }
  /// Of the pixel (x, y) * step_px; metres, 0 = none.
  float at(int x, int y) const { return metres_per_unit * static_cast<float>(units_[index(x, y)]); }

 private:
  static constexpr float metres_per_unit = static_cast<float>(1.0 / packed_depth_units_per_metre);
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  int width_ = 0, height_ = 0;
  std::vector<std::uint16_t> units_;
};

/// What the surfaces that one view measured look like to another.
struct SurfaceAgreement {
  int agree = 0;       ///< Measured there as well.
  int contradict = 0;  ///< The other one looked through the place and saw what is behind.
  int hidden = 0;      ///< Behind what the other one saw: says nothing.
  int outside = 0;     ///< Not seen by the other one, or without depth there.

  /// Of what could be judged, the share that agrees; 0 where nothing could be.
  double share() const { return agree == 0 ? 0.0 : static_cast<double>(agree) / (agree + contradict); }
  /// Share of the measurements that could be judged.
  double overlap() const {
    return agree == 0 ? 0.0 : static_cast<double>(agree + contradict) / (agree + contradict + hidden + outside);
  }
};

/// The environment measurement check of Endres et al. 2014, section III-E, on grids: both ways.
class SurfaceCheck {
 public:
  SurfaceCheck(const Camera& camera, const DepthNoise& noise);
  SurfaceAgreement compare(const DepthGrid& a, const DepthGrid& b, const SE3& a_from_b) const;

 private:
  void count(const DepthGrid& seen, const DepthGrid& by, const SE3& by_from_seen, SurfaceAgreement& sum) const;

  Camera camera_;
  DepthNoise noise_;
  int width_ = 0, height_ = 0;
  std::vector<Eigen::Vector2d> rays_;  ///< Of the grid's pixels, normalised; not a number where there is none.
};

}  // namespace rastro
