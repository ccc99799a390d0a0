// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/camera/depth_registration.h"
#include "rastro/image/image.h"

namespace rastro {

/// Puts the depth of another camera into the color image, as depth cameras do that register it themselves.
class DepthRegistrar {
 public:
  /// `color`: with its size, with or without distortion. Error where the distortion of the depth camera cannot be
  /// inverted anywhere in its image.
  DepthRegistrar(const DepthRegistration& registration, const Camera& color);

  /// Depth along the optical axis of the color camera, of the size of its image, meters. Neighboring readings of one
  /// surface are joined to triangles, so that a finer image has no holes; the surface nearest to the color camera hides
  /// what is behind it. 0 where the depth camera saw nothing, and between surfaces. RASTRO_CHECK: `depth` has the
  /// depth camera's size.
  DepthImage registered(const DepthImage& depth) const;

 private:
  struct Reading {
    float x = 0.0F, y = 0.0F;  ///< In the color image, pixels.
    float inverse = 0.0F;      ///< Of its depth in the color camera, 1/m; 0: none.
    float depth = 0.0F;        ///< In the depth camera, meters.
    bool is_drawn = false;     ///< As part of a triangle.
  };
  class Canvas;

  Image<Reading> readings_of(const DepthImage& depth) const;
  bool are_joined(const Reading& a, const Reading& b, const Reading& c) const;
  /// Two neighbors of a row and those below them, as two triangles.
  void draw_cell(Reading* row, Reading* below, Canvas& canvas) const;

  DepthRegistration registration_;
  Camera color_;
  Image<float> rays_x_, rays_y_;  ///< Of the depth camera, z = 1, in the orientation of its own frame; nan: none.
  float steepest_ = 0.0F;         ///< Difference of the depths of neighbors on one surface, as share of the depth.
};

}  // namespace rastro
