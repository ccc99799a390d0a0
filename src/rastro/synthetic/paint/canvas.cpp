// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/paint/canvas.h"

#include "rastro/base/error.h"
#include "rastro/synthetic/paint/font.h"

namespace rastro {
namespace {

int texels(double meters, double density) { return std::max(2, static_cast<int>(std::lround(meters * density))); }

float noise_step(Random& random, float amplitude) {
  return amplitude * (static_cast<float>(random.next() >> 40) * 0x1.0p-23F - 1.0F);
}

/// One row between two coarse rows, with doubled resolution along x.
void refine_row(const float* upper, const float* lower, float weight, int coarse_width, float* fine, int fine_width) {
  for (int x = 0; x < fine_width; ++x) {
    const int left = std::min((x + 1) / 2, coarse_width - 1);
    const int right = std::min(left + 1, coarse_width - 1);
    const float along = (x & 1) != 0 ? 0.25F : 0.75F;
    const float above = upper[left] + along * (upper[right] - upper[left]);
    const float below = lower[left] + along * (lower[right] - lower[left]);
    fine[x] = above + weight * (below - above);
  }
}

Image<float> refine(const Image<float>& coarse, int width, int height) {
  Image<float> fine(width, height);
  for (int y = 0; y < height; ++y) {
    const int top = std::min((y + 1) / 2, coarse.height() - 1);
    const int bottom = std::min(top + 1, coarse.height() - 1);
    refine_row(coarse.row(top), coarse.row(bottom), (y & 1) != 0 ? 0.25F : 0.75F, coarse.width(), fine.row(y), width);
  }
  return fine;
}

/// Noise of wavelength `scale` texels and all halves of it, at a lattice spacing of `spacing` texels.
Image<float> octaves(Random& random, int width, int height, double spacing, double scale, float amplitude,
                     float persistence) {
  Image<float> result(width, height);
  float step = amplitude;
  if (spacing * 2.0 <= scale) {
    const Image<float> coarse =
        octaves(random, width / 2 + 3, height / 2 + 3, spacing * 2.0, scale, amplitude, persistence);
    result = refine(coarse, width, height);
    step = amplitude * std::pow(persistence, static_cast<float>(std::round(std::log2(scale / spacing))));
  }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) result.at(x, y) += noise_step(random, step);
  return result;
}

}  // namespace

Canvas::Canvas(double width_m, double height_m, double texels_per_meter)
    : width_m_(width_m),
      height_m_(height_m),
      density_(texels_per_meter),
      values_(texels(width_m, texels_per_meter), texels(height_m, texels_per_meter)) {}

void Canvas::set_ink(const Tint& tint) {
  const auto known = std::find(inks_.begin(), inks_.end(), tint);
  ink_ = static_cast<std::uint8_t>(known - inks_.begin());
  if (known != inks_.end()) return;
  RASTRO_CHECK(inks_.size() < 250, "a canvas may have at most 249 inks");
  inks_.push_back(tint);
  if (inks_.size() == 2) ink_of_ = Image<std::uint8_t>(values_.width(), values_.height());
}

void Canvas::fill(float value) {
  blend({0, 0, width_m_, height_m_}, [&](double, double, float& texel) { texel = value; });
  for (int y = 0; y < ink_of_.height(); ++y)
    for (int x = 0; x < ink_of_.width(); ++x) ink_of_.at(x, y) = ink_;
}

void Canvas::add_noise(Random& random, double coarsest_m, float amplitude, float persistence) {
  const double scale = std::exp2(std::floor(std::log2(std::max(1.0, coarsest_m * density_))));
  // A separate random stream: later drawing must not depend on the number of texels.
  Random stream(random.next());
  const Image<float> noise = octaves(stream, values_.width(), values_.height(), 1.0, scale, amplitude, persistence);
  for (int y = 0; y < values_.height(); ++y)
    for (int x = 0; x < values_.width(); ++x) values_.at(x, y) += noise.at(x, y);
}

void Canvas::rectangle(double x0, double y0, double x1, double y1, float value, float opacity) {
  shape({x0, y0, x1, y1}, value, opacity,
        [=](double x, double y) { return std::max(std::max(x0 - x, x - x1), std::max(y0 - y, y - y1)); });
}

void Canvas::outline(double x0, double y0, double x1, double y1, double thickness, float value, float opacity) {
  line(x0, y0, x1, y0, thickness, value, opacity);
  line(x0, y1, x1, y1, thickness, value, opacity);
  line(x0, y0, x0, y1, thickness, value, opacity);
  line(x1, y0, x1, y1, thickness, value, opacity);
}

void Canvas::line(double x0, double y0, double x1, double y1, double thickness, float value, float opacity) {
  const double half = 0.5 * thickness, dx = x1 - x0, dy = y1 - y0;
  const double length_squared = std::max(dx * dx + dy * dy, 1e-12);
  const Box bounds{std::min(x0, x1) - half, std::min(y0, y1) - half, std::max(x0, x1) + half, std::max(y0, y1) + half};
  shape(bounds, value, opacity, [=](double x, double y) {
    const double along = std::clamp(((x - x0) * dx + (y - y0) * dy) / length_squared, 0.0, 1.0);
    return std::hypot(x - x0 - along * dx, y - y0 - along * dy) - half;
  });
}

void Canvas::disc(double x, double y, double radius, float value, float opacity) {
  shape({x - radius, y - radius, x + radius, y + radius}, value, opacity,
        [=](double px, double py) { return std::hypot(px - x, py - y) - radius; });
}

void Canvas::ring(double x, double y, double radius, double thickness, float value, float opacity) {
  const double outer = radius + thickness;
  shape({x - outer, y - outer, x + outer, y + outer}, value, opacity,
        [=](double px, double py) { return std::abs(std::hypot(px - x, py - y) - radius) - 0.5 * thickness; });
}

void Canvas::spot(double x, double y, double radius_x, double radius_y, float delta) {
  blend({x - 2.5 * radius_x, y - 2.5 * radius_y, x + 2.5 * radius_x, y + 2.5 * radius_y},
        [=](double px, double py, float& texel) {
          const double u = (px - x) / radius_x, v = (py - y) / radius_y;
          // Reaches zero at the border of the bounds, so that no edge is visible there.
          const double fall = std::max(0.0, 1.0 - (u * u + v * v) / 6.25);
          texel += delta * static_cast<float>(fall * fall * fall);
        });
}

void Canvas::stripes(double x0, double y0, double x1, double y1, double period, float dark, float light) {
  rectangle(x0, y0, x1, y1, dark);
  shape({x0, y0, x1, y1}, light, 1.0F, [=](double x, double y) {
    const double phase = (x - x0 + y - y0) / period;
    const double stripe = (std::abs(phase - std::floor(phase) - 0.5) - 0.25) * period * 0.7071;
    return std::max({stripe, x0 - x, x - x1, y0 - y, y - y1});
  });
}

double Canvas::text(double x, double y, double letter_height, std::string_view letters, float value, float opacity) {
  const double dot = letter_height / 7.0;
  double left = x;
  for (const char letter : letters) {
    const std::uint8_t* rows = stencil_letter(letter);
    for (int row = 0; rows != nullptr && row < 7; ++row)
      for (int column = 0; column < 5; ++column)
        if ((rows[row] >> (4 - column)) & 1)
          rectangle(left + column * dot, y + row * dot, left + (column + 1) * dot, y + (row + 1) * dot, value, opacity);
    left += 6.0 * dot;
  }
  return left - x;
}

}  // namespace rastro
