// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/image/image.h"
#include "rastro/synthetic/paint/tint.h"

namespace rastro {

/// An image of one surface to paint on. Positions and sizes are meters from the upper left corner (x right, y down),
/// values are intensities (0 black, 255 white; painters may leave that range, the texture clamps). Edges are
/// anti-aliased.
class Canvas {
 public:
  /// The size is rounded to whole texels, at least 2 x 2.
  Canvas(double width_m, double height_m, double texels_per_meter);

  double width() const { return width_m_; }
  double height() const { return height_m_; }
  double texels_per_meter() const { return density_; }
  Image<float>& values() { return values_; }
  const Image<float>& values() const { return values_; }

  /// Sets the color of subsequent drawing. Anything drawn before has the first one.
  void set_ink(const Tint& tint);
  /// The inks in the order of their first use; empty if all is gray.
  const std::vector<Tint>& inks() const { return inks_; }
  /// Ink of each texel; empty with less than two.
  const Image<std::uint8_t>& ink_of() const { return ink_of_; }

  void fill(float value);
  /// Adds smooth random variation of every wavelength from `coarsest_m` down to one texel, none of it periodic.
  /// `amplitude` is that of the coarsest wavelength in intensity levels; each halving of the wavelength multiplies it
  /// by `persistence`.
  void add_noise(Random& random, double coarsest_m, float amplitude, float persistence);

  struct Box {
    double x0, y0, x1, y1;
  };
  /// Draws `value` where the signed distance (meters, negative inside) is negative; `opacity` 0..1.
  template <typename SignedDistance>
  void shape(const Box& bounds, float value, float opacity, SignedDistance&& signed_distance) {
    blend(bounds, [&](double x, double y, float& texel) {
      const double coverage = std::clamp(0.5 - signed_distance(x, y) * density_, 0.0, 1.0);
      texel += static_cast<float>(coverage) * opacity * (value - texel);
      if (!ink_of_.empty() && static_cast<float>(coverage) * opacity > 0.5F) ink_at(&texel) = ink_;
    });
  }
  /// Calls change(x, y, texel) for every texel in the bounds.
  template <typename Change>
  void blend(const Box& bounds, Change&& change) {
    const int x_begin = std::max(0, static_cast<int>(std::floor(bounds.x0 * density_ - 1.0)));
    const int y_begin = std::max(0, static_cast<int>(std::floor(bounds.y0 * density_ - 1.0)));
    const int x_end = std::min(values_.width(), static_cast<int>(std::ceil(bounds.x1 * density_ + 1.0)));
    const int y_end = std::min(values_.height(), static_cast<int>(std::ceil(bounds.y1 * density_ + 1.0)));
    for (int y = y_begin; y < y_end; ++y)
      for (int x = x_begin; x < x_end; ++x) change((x + 0.5) / density_, (y + 0.5) / density_, values_.at(x, y));
  }

  void rectangle(double x0, double y0, double x1, double y1, float value, float opacity = 1.0F);
  /// The border of the rectangle only, `thickness` wide, centered on its edge.
  void outline(double x0, double y0, double x1, double y1, double thickness, float value, float opacity = 1.0F);
  void line(double x0, double y0, double x1, double y1, double thickness, float value, float opacity = 1.0F);
  void disc(double x, double y, double radius, float value, float opacity = 1.0F);
  void ring(double x, double y, double radius, double thickness, float value, float opacity = 1.0F);
  /// A soft blob: adds `delta` at its center, with a Gaussian fall-off.
  void spot(double x, double y, double radius_x, double radius_y, float delta);
  /// Slanted stripes of two values, as on hazard markings.
  void stripes(double x0, double y0, double x1, double y1, double period, float dark, float light);
  /// Capital letters, digits, '-' and '.'; other characters are blank. Returns the width drawn.
  double text(double x, double y, double letter_height, std::string_view letters, float value, float opacity = 1.0F);

 private:
  std::uint8_t& ink_at(const float* texel) {
    const std::ptrdiff_t index = texel - values_.row(0);
    return ink_of_.at(static_cast<int>(index % values_.stride()), static_cast<int>(index / values_.stride()));
  }

  double width_m_, height_m_, density_;
  Image<float> values_;
  std::vector<Tint> inks_;
  std::uint8_t ink_ = 0;
  Image<std::uint8_t> ink_of_;
};

}  // namespace rastro
