// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/undistort_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/camera/distortion.h"

namespace rastro {
namespace {

// An undistorted image cannot show rays farther out: at 80 degrees a pixel is already stretched thirtyfold.
constexpr double farthest_ray = 5.7;

struct Rectangle {
  double left, right, top, bottom;
};

/// Rays of the recorded image's border: the largest rectangle inside it and the smallest around it.
struct BorderRays {
  Rectangle inner, outer;
};

std::optional<Eigen::Vector2d> useful_ray(const Camera& camera, double x, double y) {
  auto ray = camera.unproject({x, y});
  if (ray && ray->norm() <= farthest_ray) return ray;
  // No ray there (a fisheye's black corner): the last valid one towards the center.
  const Eigen::Vector2d middle(camera.cx, camera.cy), outward = Eigen::Vector2d(x, y) - middle;
  double low = 0.0, high = 1.0;
  std::optional<Eigen::Vector2d> best;
  for (int i = 0; i < 40; ++i) {
    const double part = 0.5 * (low + high);
    const auto nearer = camera.unproject(middle + part * outward);
    const bool useful = nearer && nearer->norm() <= farthest_ray;
    (useful ? low : high) = part;
    if (useful) best = nearer;
  }
  return best;
}

BorderRays border_rays(const Camera& camera) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  BorderRays result{{-infinity, infinity, -infinity, infinity}, {infinity, -infinity, infinity, -infinity}};
  auto& [inner, outer] = result;
  const auto around = [&outer = outer](const Eigen::Vector2d& ray) {
    outer = {std::min(outer.left, ray.x()), std::max(outer.right, ray.x()), std::min(outer.top, ray.y()),
             std::max(outer.bottom, ray.y())};
  };
  const double right = camera.width - 1.0, bottom = camera.height - 1.0;
  for (int y = 0; y < camera.height; ++y) {
    const auto at_left = useful_ray(camera, 0.0, y), at_right = useful_ray(camera, right, y);
    if (!at_left || !at_right) continue;
    inner.left = std::max(inner.left, at_left->x());
    inner.right = std::min(inner.right, at_right->x());
    around(*at_left);
    around(*at_right);
  }
  for (int x = 0; x < camera.width; ++x) {
    const auto at_top = useful_ray(camera, x, 0.0), at_bottom = useful_ray(camera, x, bottom);
    if (!at_top || !at_bottom) continue;
    inner.top = std::max(inner.top, at_top->y());
    inner.bottom = std::min(inner.bottom, at_bottom->y());
    around(*at_top);
    around(*at_bottom);
  }
  return result;
}

bool usable(const Rectangle& r) {
  return r.right > r.left && r.bottom > r.top && std::isfinite(r.right - r.left) && std::isfinite(r.bottom - r.top);
}

/// For an intensity, 0 to 255; faster than lround().
inline std::uint8_t rounded(float gray) {
  return static_cast<std::uint8_t>(gray + 0.5F);  // NOLINT(bugprone-incorrect-roundings): no intensity is negative.
}

/// Between four pixels that are all inside.
inline std::uint8_t blend(GrayView image, float x, float y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const float along = x - static_cast<float>(left), down = y - static_cast<float>(top);
  const std::uint8_t *above_left = image.row(top) + left, *below_left = above_left + image.stride;
  const float above = above_left[0] + along * (above_left[1] - above_left[0]);
  const float below = below_left[0] + along * (below_left[1] - below_left[0]);
  return rounded(above + down * (below - above));
}

/// Also at the last row and column; black outside.
std::uint8_t sample(GrayView image, float x, float y) {
  // Also false for NaN.
  if (!(x >= 0.0F && y >= 0.0F && x <= static_cast<float>(image.width - 1) &&
        y <= static_cast<float>(image.height - 1)))
    return 0;
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = std::min(left + 1, image.width - 1), bottom = std::min(top + 1, image.height - 1);
  const float along = x - static_cast<float>(left), down = y - static_cast<float>(top);
  const float above = image.at(left, top) + along * (image.at(right, top) - image.at(left, top));
  const float below = image.at(left, bottom) + along * (image.at(right, bottom) - image.at(left, bottom));
  return rounded(above + down * (below - above));
}

/// Zero where a zero lies within `margin` rows and columns.
void shrink(GrayImage& mask, int margin) {
  const GrayImage before = mask;
  const auto is_shown = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < before.width() && y < before.height() && before.at(x, y) != 0;
  };
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      // Only pixels at an edge reach farther than their neighbors.
      if (is_shown(x, y) || !(is_shown(x - 1, y) || is_shown(x + 1, y) || is_shown(x, y - 1) || is_shown(x, y + 1)))
        continue;
      const int left = std::max(0, x - margin), right = std::min(mask.width(), x + margin + 1);
      for (int row = std::max(0, y - margin); row < std::min(mask.height(), y + margin + 1); ++row)
        std::fill(mask.row(row) + left, mask.row(row) + right, std::uint8_t{0});
    }
  }
}

}  // namespace

Camera undistorted_camera(const Camera& camera, double alpha) {
  RASTRO_CHECK(camera.width > 1 && camera.height > 1 && camera.fx > 0.0 && camera.fy > 0.0,
               "only a camera with a size can be undistorted");
  RASTRO_CHECK(alpha >= 0.0 && alpha <= 1.0, "alpha is between 0 and 1");
  Camera result = camera;
  result.distortion = Distortion::none;
  result.coefficients = {};
  if (camera.distortion == Distortion::none) return result;
  const auto [inner, outer] = border_rays(camera);
  if (!usable(inner) || !usable(outer)) return result;
  const auto mix = [alpha](double from, double to) { return (1.0 - alpha) * from + alpha * to; };
  const double left = mix(inner.left, outer.left), right = mix(inner.right, outer.right);
  const double top = mix(inner.top, outer.top), bottom = mix(inner.bottom, outer.bottom);
  result.fx = (camera.width - 1) / (right - left);
  result.fy = (camera.height - 1) / (bottom - top);
  result.cx = -result.fx * left;
  result.cy = -result.fy * top;
  return result;
}

UndistortMap undistort_map(const Camera& camera, const Camera& undistorted, const SO3& camera_from_undistorted) {
  RASTRO_CHECK(undistorted.distortion == Distortion::none, "an undistorted camera is a pinhole");
  UndistortMap map{undistorted, Image<float>(undistorted.width, undistorted.height),
                   Image<float>(undistorted.width, undistorted.height)};
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (int y = 0; y < undistorted.height; ++y)
    for (int x = 0; x < undistorted.width; ++x) {
      const Eigen::Vector2d ray((x - undistorted.cx) / undistorted.fx, (y - undistorted.cy) / undistorted.fy);
      const auto pixel = camera.project(camera_from_undistorted * Eigen::Vector3d(ray.homogeneous()));
      map.x.at(x, y) = pixel ? static_cast<float>(pixel->x()) : nan;
      map.y.at(x, y) = pixel ? static_cast<float>(pixel->y()) : nan;
    }
  return map;
}

GrayImage remap(GrayView recorded, const UndistortMap& map, TaskPool* pool) {
  constexpr int rows_at_a_time = 16;
  GrayImage result(map.camera.width, map.camera.height);
  const auto last_x = static_cast<float>(recorded.width - 1), last_y = static_cast<float>(recorded.height - 1);
  const auto rows = [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      const float *from_x = map.x.row(y), *from_y = map.y.row(y);
      std::uint8_t* to = result.row(y);
      for (int x = 0; x < result.width(); ++x) {
        const float u = from_x[x], v = from_y[x];
        const bool well_inside = u >= 0.0F && v >= 0.0F && u < last_x && v < last_y;
        to[x] = well_inside ? blend(recorded, u, v) : sample(recorded, u, v);
      }
    }
  };
  pool != nullptr ? pool->for_chunks(0, result.height(), rows_at_a_time, rows) : rows(0, result.height());
  return result;
}

GrayImage shown_by(const UndistortMap& map, int recorded_width, int recorded_height, int margin) {
  GrayImage shown(map.camera.width, map.camera.height);
  for (int y = 0; y < shown.height(); ++y) {
    for (int x = 0; x < shown.width(); ++x) {
      const float u = map.x.at(x, y), v = map.y.at(x, y);
      const bool inside = u >= 0.0F && v >= 0.0F && u <= static_cast<float>(recorded_width - 1) &&
                          v <= static_cast<float>(recorded_height - 1);
      shown.at(x, y) = inside ? 255 : 0;
    }
  }
  if (margin > 0) shrink(shown, margin);
  return shown;
}

}  // namespace rastro
