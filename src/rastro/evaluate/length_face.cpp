// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_face.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double nearest_m = 0.15;          ///< Minimum depth used.
constexpr int fewest_points = 25;           ///< Of a face.
constexpr int most_pixels = 12000;          ///< Used in one region.
constexpr int drawn_planes = 80;            ///< By RANSAC.
constexpr std::size_t most_voters = 400;    ///< In RANSAC.
constexpr double gate_sigmas = 3.0;         ///< A depth farther from the plane is of another surface.
constexpr double cos_largest_tilt = 0.8;    ///< Against the expected normal.
constexpr double pixels_per_sample = 16.0;  ///< Depths of neighbors are not independent.
constexpr double shared_noise = 0.15;       ///< Part of the depth noise common to all pixels of a face.

struct Measured {
  Vector3d ray;
  double inverse_depth = 0.0, sigma = 0.0;  ///< Both 1 / m.
};

struct PixelBox {
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
  std::int64_t count() const { return x1 < x0 || y1 < y0 ? 0 : std::int64_t{x1 - x0 + 1} * (y1 - y0 + 1); }
};

/// The pixels that may show the region; empty if it reaches behind the camera.
PixelBox pixels_of(const LengthView& view, const LengthRegion& region) {
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d along;
    for (int k = 0; k < 3; ++k) along[k] = (corner >> k & 1) != 0 ? region.high[k] : region.low[k];
    const Vector3d point = region.center + region.axes * along;
    const auto pixel = point.z() < nearest_m ? std::nullopt : view.camera.project(point);
    if (!pixel) return {};
    x0 = std::min(x0, pixel->x()), x1 = std::max(x1, pixel->x());
    y0 = std::min(y0, pixel->y()), y1 = std::max(y1, pixel->y());
  }
  const double last_x = view.depth.width() - 1, last_y = view.depth.height() - 1;
  if (x1 < 0.0 || y1 < 0.0 || x0 > last_x || y0 > last_y) return {};
  return {static_cast<int>(std::max(0.0, x0)), static_cast<int>(std::max(0.0, y0)),
          static_cast<int>(std::min(last_x, x1)), static_cast<int>(std::min(last_y, y1))};
}

bool inside(const LengthRegion& region, const Vector3d& point, int axes) {
  const Vector3d along = region.axes.transpose() * (point - region.center);
  for (int k = 0; k < axes; ++k)
    if (along[k] < region.low[k] || along[k] > region.high[k]) return false;
  return true;
}

/// Calls visit(ray, depth) for the pixels of the region's image, evenly thinned out if they are many.
template <typename Visit>
void for_pixels(const LengthView& view, const PixelBox& box, Visit&& visit) {
  const auto stride =
      static_cast<int>(std::ceil(std::sqrt(static_cast<double>(box.count()) / static_cast<double>(most_pixels))));
  for (int y = box.y0; y <= box.y1; y += std::max(1, stride)) {
    for (int x = box.x0; x <= box.x1; x += std::max(1, stride)) {
      const auto ray = view.camera.unproject(Vector2d(x, y));
      if (ray) visit(Vector3d(ray->x(), ray->y(), 1.0), static_cast<double>(view.depth.at(x, y)));
    }
  }
}

std::vector<Measured> measured_in(const LengthView& view, const LengthRegion& region, const PixelBox& box) {
  std::vector<Measured> found;
  for_pixels(view, box, [&](const Vector3d& ray, double z) {
    if (z < nearest_m || !inside(region, z * ray, 3)) return;
    found.push_back({ray, 1.0 / z, view.depth_sigma(z) / (z * z)});
  });
  return found;
}

bool faces_as_expected(const LengthRegion& region, const Vector3d& inverse) {
  const double norm = inverse.norm();
  if (!(norm > 1e-6) || !std::isfinite(norm)) return false;
  return !region.normal_known || std::abs(inverse.dot(region.axes.col(2))) >= cos_largest_tilt * norm;
}

/// Fischler and Bolles 1981.
std::optional<Vector3d> drawn_plane(const std::vector<Measured>& all, const LengthRegion& region, Random& random) {
  std::vector<const Measured*> voters;
  const std::size_t step = std::max<std::size_t>(1, all.size() / most_voters);
  for (std::size_t i = 0; i < all.size(); i += step) voters.push_back(&all[i]);
  const auto count = static_cast<std::uint32_t>(voters.size());
  std::optional<Vector3d> best;
  int most = fewest_points / 4;
  for (int draw = 0; draw < drawn_planes; ++draw) {
    Matrix3d rays;
    Vector3d inverse_depths;
    for (int k = 0; k < 3; ++k) {
      const Measured& one = *voters[random.below(count)];
      rays.row(k) = one.ray.transpose();
      inverse_depths[k] = one.inverse_depth;
    }
    if (std::abs(rays.determinant()) < 1e-9) continue;
    const Vector3d inverse = rays.inverse() * inverse_depths;
    if (!faces_as_expected(region, inverse)) continue;
    const auto agree = static_cast<int>(std::count_if(voters.begin(), voters.end(), [&](const Measured* one) {
      return std::abs(inverse.dot(one->ray) - one->inverse_depth) < gate_sigmas * one->sigma;
    }));
    if (agree > most) most = agree, best = inverse;
  }
  return best;
}

/// Iteratively reweighted least squares; leaves the information of the last step in `information`.
Vector3d refined(const std::vector<Measured>& all, Vector3d inverse, Matrix3d& information) {
  const TukeyKernel kernel{gate_sigmas};
  for (int round = 0; round < 6; ++round) {
    Matrix3d normal = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (const Measured& one : all) {
      const double error = (inverse.dot(one.ray) - one.inverse_depth) / one.sigma;
      const double weight = kernel.weight(error * error) / (one.sigma * one.sigma);
      normal += weight * one.ray * one.ray.transpose();
      right += weight * one.inverse_depth * one.ray;
    }
    information = normal;
    const Eigen::LDLT<Matrix3d> solver(normal);
    const Vector3d next = solver.solve(right);
    if (solver.info() != Eigen::Success || !next.allFinite()) break;
    inverse = next;
  }
  return inverse;
}

void count_support(const LengthView& view, const LengthRegion& region, const PixelBox& box, LengthFace& face) {
  std::int64_t compared = 0, agreeing = 0;
  double squares = 0.0;
  for_pixels(view, box, [&](const Vector3d& ray, double z) {
    const double expected = face.depth_at(ray);
    if (!(expected > nearest_m && expected < 100.0) || !inside(region, expected * ray, 2)) return;
    ++compared;
    if (z < nearest_m || std::abs(z - expected) > gate_sigmas * view.depth_sigma(expected)) return;
    ++agreeing;
    squares += (z - expected) * (z - expected);
  });
  face.points = static_cast<int>(agreeing);
  face.support = compared > 0 ? static_cast<double>(agreeing) / static_cast<double>(compared) : 0.0;
  face.residual_m = agreeing > 0 ? std::sqrt(squares / static_cast<double>(agreeing)) : 0.0;
}

}  // namespace

bool LengthView::has_depth() const {
  for (int y = 0; y < depth.height(); ++y)
    if (std::any_of(depth.row(y), depth.row(y) + depth.width(), [](float z) { return z > 0.0F; })) return true;
  return false;
}

double LengthFace::depth_sigma_at(const Vector3d& ray) const {
  const double z = depth_at(ray);
  return z * z * std::sqrt(std::max(0.0, ray.dot(covariance * ray)));
}

std::optional<LengthFace> find_face(const LengthView& view, const LengthRegion& region, std::uint64_t seed) {
  const PixelBox box = pixels_of(view, region);
  const std::vector<Measured> all = measured_in(view, region, box);
  if (static_cast<int>(all.size()) < fewest_points) return std::nullopt;
  Random random(seed);
  const auto start = drawn_plane(all, region, random);
  if (!start) return std::nullopt;
  Matrix3d information = Matrix3d::Zero();
  LengthFace face;
  face.inverse = refined(all, *start, information);
  if (!faces_as_expected(region, face.inverse)) return std::nullopt;
  count_support(view, region, box, face);
  if (face.points < fewest_points) return std::nullopt;
  // The common error of all pixels moves the face as a whole: a change of `inverse` along its z, where rays have a 1.
  const double z = std::max(nearest_m, (region.center + region.axes * (0.5 * (region.low + region.high))).z());
  const double shared = shared_noise * view.depth_sigma(z) / (z * z);
  face.covariance = pixels_per_sample * (information + 1e-9 * Matrix3d::Identity()).inverse();
  face.covariance(2, 2) += shared * shared;
  return face;
}

}  // namespace rastro
