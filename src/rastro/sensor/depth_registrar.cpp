// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/depth_registrar.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// Tangent of the angle between ray and normal beyond which neighbors are taken to be of two surfaces (85 degrees).
constexpr double steepest_surface = 11.4;
/// Corners of triangles lie on pixels where both cameras are the same; rounding must not leave them out.
constexpr float rim = 1e-3F;
/// Wider triangles are no surface, but a lens model beyond its range.
constexpr float widest = 200.0F;
constexpr double farthest_pixel = 1e6;

// std::floor and std::ceil are calls where the processor is not known to have them.
int floor_of(float value) {
  const int whole = static_cast<int>(value);
  return whole - (static_cast<float>(whole) > value ? 1 : 0);
}
int ceil_of(float value) {
  const int whole = static_cast<int>(value);
  return whole + (static_cast<float>(whole) < value ? 1 : 0);
}

}  // namespace

/// Depth with the nearest surface in front.
class DepthRegistrar::Canvas {
 public:
  Canvas(int width, int height) : depth_(width, height) {}

  /// A surface that shows its back is hidden by its front; `a`, `b`, `c` are clockwise as seen.
  void draw(const Reading& a, const Reading& b, const Reading& c) {
    const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    const float left = std::min({a.x, b.x, c.x}), right = std::max({a.x, b.x, c.x});
    const float top = std::min({a.y, b.y, c.y}), bottom = std::max({a.y, b.y, c.y});
    if (!(area > 1e-6F) || !(right - left < widest) || !(bottom - top < widest)) return;
    const float share = 1.0F / area;
    const int last_x = std::min(depth_.width() - 1, floor_of(right + rim));
    const int last_y = std::min(depth_.height() - 1, floor_of(bottom + rim));
    const int first_x = std::max(0, ceil_of(left - rim));
    for (int y = std::max(0, ceil_of(top - rim)); y <= last_y; ++y)
      for (int x = first_x; x <= last_x; ++x) {
        const float u = static_cast<float>(x), v = static_cast<float>(y);
        const float of_a = ((b.x - u) * (c.y - v) - (c.x - u) * (b.y - v)) * share;
        const float of_b = ((c.x - u) * (a.y - v) - (a.x - u) * (c.y - v)) * share;
        const float of_c = 1.0F - of_a - of_b;
        // Of a plane the inverse of the depth is linear in the image.
        if (std::min({of_a, of_b, of_c}) >= -rim) put(x, y, of_a * a.inverse + of_b * b.inverse + of_c * c.inverse);
      }
  }

  void put(const Reading& alone) {
    const float x = std::round(alone.x), y = std::round(alone.y);
    if (x >= 0.0F && y >= 0.0F && x < static_cast<float>(depth_.width()) && y < static_cast<float>(depth_.height()))
      put(static_cast<int>(x), static_cast<int>(y), alone.inverse);
  }

  /// Depth instead of its inverse.
  DepthImage take() {
    for (int y = 0; y < depth_.height(); ++y)
      for (int x = 0; x < depth_.width(); ++x)
        if (float& at = depth_.at(x, y); at > 0.0F) at = 1.0F / at;
    return std::move(depth_);
  }

 private:
  void put(int x, int y, float inverse) {
    float& at = depth_.at(x, y);
    at = std::max(at, inverse);
  }

  DepthImage depth_;  ///< Its inverse until it is taken: 0 is farther than everything.
};

DepthRegistrar::DepthRegistrar(const DepthRegistration& registration, const Camera& color)
    : registration_(registration),
      color_(color),
      rays_x_(registration.depth_camera.width, registration.depth_camera.height),
      rays_y_(registration.depth_camera.width, registration.depth_camera.height),
      steepest_(static_cast<float>(steepest_surface / registration.depth_camera.fx)) {
  RASTRO_CHECK(color.width > 0 && color.height > 0, "depth is put into an image of known size");
  bool any = false;
  for (int y = 0; y < rays_x_.height(); ++y)
    for (int x = 0; x < rays_x_.width(); ++x) {
      const auto ray = registration.depth_camera.unproject({static_cast<double>(x), static_cast<double>(y)});
      rays_x_.at(x, y) = ray ? static_cast<float>(ray->x()) : std::nanf("");
      rays_y_.at(x, y) = ray ? static_cast<float>(ray->y()) : std::nanf("");
      any = any || ray.has_value();
    }
  if (!any)
    throw Error("the distortion of the depth camera cannot be inverted", "depth_camera", "calibrate it once more");
}

Image<DepthRegistrar::Reading> DepthRegistrar::readings_of(const DepthImage& depth) const {
  const Eigen::Matrix3d rotation = registration_.color_from_depth.rotation().matrix();
  const Eigen::Vector3d& translation = registration_.color_from_depth.translation();
  Image<Reading> readings(depth.width(), depth.height());
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const auto z = static_cast<double>(depth.at(x, y));
      if (!(z > 0.0) || std::isnan(rays_x_.at(x, y))) continue;
      const Eigen::Vector3d ray(rays_x_.at(x, y), rays_y_.at(x, y), 1.0);
      const Eigen::Vector3d point = rotation * (z * ray) + translation;
      if (const auto pixel = color_.project(point); pixel && pixel->cwiseAbs().maxCoeff() < farthest_pixel)
        readings.at(x, y) = {static_cast<float>(pixel->x()), static_cast<float>(pixel->y()),
                             static_cast<float>(1.0 / point.z()), depth.at(x, y)};
    }
  return readings;
}

bool DepthRegistrar::are_joined(const Reading& a, const Reading& b, const Reading& c) const {
  const float nearest = std::min({a.depth, b.depth, c.depth}), farthest = std::max({a.depth, b.depth, c.depth});
  return std::min({a.inverse, b.inverse, c.inverse}) > 0.0F && farthest - nearest <= steepest_ * nearest;
}

void DepthRegistrar::draw_cell(Reading* row, Reading* below, Canvas& canvas) const {
  const auto draw = [&](Reading& a, Reading& b, Reading& c) {
    if (!are_joined(a, b, c)) return;
    a.is_drawn = b.is_drawn = c.is_drawn = true;
    canvas.draw(a, b, c);
  };
  // Along the diagonal that stays on one surface.
  if (std::abs(row[0].depth - below[1].depth) < std::abs(row[1].depth - below[0].depth)) {
    draw(row[0], row[1], below[1]);
    draw(row[0], below[1], below[0]);
  } else {
    draw(row[0], row[1], below[0]);
    draw(row[1], below[1], below[0]);
  }
}

DepthImage DepthRegistrar::registered(const DepthImage& depth) const {
  RASTRO_CHECK(depth.width() == rays_x_.width() && depth.height() == rays_x_.height(),
               "depth to be registered has the size of its camera");
  Image<Reading> readings = readings_of(depth);
  Canvas canvas(color_.width, color_.height);
  for (int y = 0; y + 1 < depth.height(); ++y)
    for (int x = 0; x + 1 < depth.width(); ++x) draw_cell(readings.row(y) + x, readings.row(y + 1) + x, canvas);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x)
      if (const Reading& each = readings.at(x, y); !each.is_drawn && each.inverse > 0.0F) canvas.put(each);
  return canvas.take();
}

}  // namespace rastro
