// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/distortion.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace rastro {
namespace {

/// Coefficients of a polynomial of degree 4, lowest first.
using Polynomial = std::array<double, 5>;

/// Whether every Bernstein coefficient is positive, and with it the polynomial on the interval; otherwise halves it.
bool bernstein_positive(Polynomial b, int depth) {
  if (!(b[0] > 0.0) || !(b[4] > 0.0)) return false;  // The values at both ends.
  if (b[1] > 0.0 && b[2] > 0.0 && b[3] > 0.0) return true;
  if (depth == 0) return false;
  Polynomial left, right = b;  // De Casteljau's subdivision.
  for (int i = 0; i < 5; ++i) {
    left[i] = right[0];
    for (int j = 0; j < 4 - i; ++j) right[j] = 0.5 * (right[j] + right[j + 1]);
  }
  // `right` was subdivided in place from the front: its entries now hold the right half.
  return bernstein_positive(left, depth - 1) && bernstein_positive(right, depth - 1);
}

/// Whether 1 + p1 x + ... + p4 x^4 > 0 on [0, end].
bool positive_up_to(const Polynomial& p, double end) {
  const double a = p[1] * end, b = p[2] * end * end, c = p[3] * end * end * end, d = p[4] * end * end * end * end;
  return bernstein_positive(
      {1.0, 1.0 + a / 4.0, 1.0 + a / 2.0 + b / 6.0, 1.0 + 0.75 * a + b / 2.0 + c / 4.0, 1.0 + a + b + c + d}, 40);
}

/// Whether a polynomial of degree 6 with p[0] = 1 is positive on [0, end], as positive_up_to().
bool sextic_positive(std::array<double, 7> b, int depth) {
  if (!(b[0] > 0.0) || !(b[6] > 0.0)) return false;
  if (std::all_of(b.begin(), b.end(), [](double value) { return value > 0.0; })) return true;
  if (depth == 0) return false;
  std::array<double, 7> left{};
  for (std::size_t i = 0; i < 7; ++i) {
    left[i] = b[0];
    for (std::size_t j = 0; j < 6 - i; ++j) b[j] = 0.5 * (b[j] + b[j + 1]);
  }
  return sextic_positive(left, depth - 1) && sextic_positive(b, depth - 1);
}

bool sextic_positive_up_to(const std::array<double, 7>& p, double end) {
  constexpr double choose[7][7] = {
      {1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}, {1, 6, 15, 20, 15, 6, 1}};
  std::array<double, 7> bernstein{};
  double power = 1.0;
  for (std::size_t j = 0; j < 7; ++j, power *= end)
    for (std::size_t i = j; i < 7; ++i) bernstein[i] += choose[i][j] / choose[6][j] * p[j] * power;
  return sextic_positive(bernstein, 40);
}

/// Derivative of the distorted radius by the radius (radial-tangential) or by the angle (equidistant), in its square.
Polynomial growth(const Camera& camera) {
  const auto& k = camera.coefficients;
  if (camera.distortion == Distortion::equidistant) return {1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k[2], 9.0 * k[3]};
  return {1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k[4], 0.0};
}

/// Of the rational model: 1 + k4 s + k5 s^2 + k6 s^3 in the square s of the radius.
Polynomial denominator(const Camera& camera) {
  const auto& k = camera.coefficients;
  return {1.0, k[5], k[6], k[7], 0.0};
}

/// Derivative of the rational model's radius, times its denominator squared: N D + 2 s (N' D - N D').
std::array<double, 7> rational_growth(const Camera& camera) {
  const auto& k = camera.coefficients;
  const std::array<double, 4> above = {1.0, k[0], k[1], k[4]}, below = {1.0, k[5], k[6], k[7]};
  std::array<double, 7> result{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      result[i + j] += above[i] * below[j] * (1.0 + 2.0 * (static_cast<double>(i) - static_cast<double>(j)));
  return result;
}

/// Whether the distorted radius grows from the axis to this radius (angle of the equidistant model).
bool grows_up_to(const Camera& camera, double end) {
  if (camera.distortion != Distortion::rational) return positive_up_to(growth(camera), end * end);
  return positive_up_to(denominator(camera), end * end) && sextic_positive_up_to(rational_growth(camera), end * end);
}

double evaluate(const Polynomial& p, double x) { return p[0] + x * (p[1] + x * (p[2] + x * (p[3] + x * p[4]))); }

/// Rays closer to the axis than this are on it: their squares underflow.
constexpr double on_axis = 1e-100;

/// Largest difference, in focal lengths, at which a ray counts as imaged at the target.
double tolerance_at(double radius) { return 1e-11 * (1.0 + radius); }

struct Distorted {
  Eigen::Vector2d value;
  Eigen::Matrix2d jacobian;
};

struct RadialPart {
  double factor;
  double slope;  ///< Of the factor by r^2, twice: d(rr)/dx = 2x.
};

RadialPart radial_part(const Camera& camera, double rr) {
  const auto& k = camera.coefficients;
  const double k1 = k[0], k2 = k[1], k3 = k[4];
  const double above = 1.0 + rr * (k1 + rr * (k2 + rr * k3));
  const double slope = 2.0 * (k1 + rr * (2.0 * k2 + rr * 3.0 * k3));
  if (camera.distortion != Distortion::rational) return {above, slope};
  const double below = 1.0 + rr * (k[5] + rr * (k[6] + rr * k[7]));
  const double below_slope = 2.0 * (k[5] + rr * (2.0 * k[6] + rr * 3.0 * k[7]));
  return {above / below, (slope - above / below * below_slope) / below};
}

Distorted radial_tangential(const Camera& camera, const Eigen::Vector2d& ray) {
  const double p1 = camera.coefficients[2], p2 = camera.coefficients[3];
  const double x = ray.x(), y = ray.y(), xx = x * x, yy = y * y, xy = x * y, rr = xx + yy;
  const auto [radial, slope] = radial_part(camera, rr);
  Distorted result;
  result.value << x * radial + 2.0 * p1 * xy + p2 * (rr + 2.0 * xx), y * radial + p1 * (rr + 2.0 * yy) + 2.0 * p2 * xy;
  const double mixed = slope * xy + 2.0 * p1 * x + 2.0 * p2 * y;
  result.jacobian << radial + slope * xx + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
      radial + slope * yy + 6.0 * p1 * y + 2.0 * p2 * x;
  return result;
}

/// Distorted angle of an angle to the optical axis.
double distorted_angle(const Camera& camera, double angle) {
  const auto& k = camera.coefficients;
  const double s = angle * angle;
  return angle * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))));
}

Distorted equidistant(const Camera& camera, const Eigen::Vector2d& ray) {
  const double rr = ray.squaredNorm(), r = std::sqrt(rr);
  if (r < on_axis) return {ray, Eigen::Matrix2d::Identity()};
  const double angle = std::atan(r);
  const double scale = distorted_angle(camera, angle) / r;
  const double growth_by_r = evaluate(growth(camera), angle * angle) / (1.0 + rr);
  const Eigen::Matrix2d radial = ray * ray.transpose() / rr;
  return {scale * ray, scale * (Eigen::Matrix2d::Identity() - radial) + growth_by_r * radial};
}

std::optional<Distorted> distort_checked(const Camera& camera, const Eigen::Vector2d& ray) {
  if (!ray.allFinite()) return std::nullopt;
  if (camera.distortion == Distortion::none) return Distorted{ray, Eigen::Matrix2d::Identity()};
  const bool fisheye = camera.distortion == Distortion::equidistant;
  const double radius = fisheye ? std::atan(ray.norm()) : ray.norm();
  if (!grows_up_to(camera, radius)) return std::nullopt;
  const Distorted result = fisheye ? equidistant(camera, ray) : radial_tangential(camera, ray);
  // The tangential part can fold the plane too.
  if (!(result.jacobian.determinant() > 0.0) || !result.value.allFinite()) return std::nullopt;
  return result;
}

/// Largest radius (or angle) at which the model still grows, by bisection; `end` if it grows up to there.
double growing_up_to(const Camera& camera, double end) {
  if (grows_up_to(camera, end)) return end;
  double low = 0.0, high = end;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (grows_up_to(camera, middle) ? low : high) = middle;
  }
  return low;
}

/// Angle or radius whose distorted value is `wanted`: Newton inside a bracket that bisection shrinks, so it cannot
/// escape.
template <typename Value, typename Slope>
std::optional<double> solve_growing(const Value& value, const Slope& slope_at, double wanted, double high) {
  double low = 0.0, x = std::min(wanted, 0.5 * high);
  if (!(value(high) >= wanted)) return std::nullopt;
  for (int i = 0; i < 100; ++i) {
    const double residual = value(x) - wanted;
    (residual > 0.0 ? high : low) = x;
    const double slope = slope_at(x);
    double next = slope > 0.0 ? x - residual / slope : low - 1.0;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) <= 1e-15 * x) return next;
    x = next;
  }
  return x;
}

std::optional<Eigen::Vector2d> undistort_equidistant(const Camera& camera, const Eigen::Vector2d& distorted) {
  const double radius = distorted.norm();
  if (radius < on_axis) return distorted;
  constexpr double right_angle = 0.5 * std::numbers::pi;
  const Polynomial derivative = growth(camera);
  double end = right_angle * (1.0 - 1e-12);
  if (!positive_up_to(derivative, end * end)) end = growing_up_to(camera, end);
  const auto angle = solve_growing([&](double a) { return distorted_angle(camera, a); },
                                   [&](double a) { return evaluate(derivative, a * a); }, radius, end);
  if (!angle || !(std::abs(distorted_angle(camera, *angle) - radius) <= tolerance_at(radius))) return std::nullopt;
  return distorted * (std::tan(*angle) / radius);
}

constexpr int newton_steps = 20;

/// Newton in the plane; steps that do not reduce the error are halved. nullopt if it does not converge.
std::optional<Eigen::Vector2d> newton_radial_tangential(const Camera& camera, const Eigen::Vector2d& distorted,
                                                        Eigen::Vector2d ray) {
  const double tolerance = 1e-14 * (1.0 + distorted.norm());
  Distorted now = radial_tangential(camera, ray);
  double error = (now.value - distorted).norm();
  for (int step = 0; step < newton_steps && error > tolerance; ++step) {
    const double determinant = now.jacobian.determinant();
    if (!(determinant > 0.0)) return std::nullopt;
    const Eigen::Vector2d residual = now.value - distorted;
    Eigen::Vector2d change(now.jacobian(1, 1) * residual.x() - now.jacobian(0, 1) * residual.y(),
                           now.jacobian(0, 0) * residual.y() - now.jacobian(1, 0) * residual.x());
    change /= determinant;
    bool nearer = false;
    for (int halving = 0; halving < 10 && !nearer; ++halving, change *= 0.5) {
      const Distorted next = radial_tangential(camera, ray - change);
      const double next_error = (next.value - distorted).norm();
      nearer = next_error < error && next.jacobian.determinant() > 0.0;
      if (nearer) {
        ray -= change;
        now = next;
        error = next_error;
      }
    }
    if (!nearer) break;  // At the limit of rounding, or stuck: the caller checks the error.
  }
  if (!(error <= tolerance_at(distorted.norm()))) return std::nullopt;
  if (!grows_up_to(camera, ray.norm())) return std::nullopt;
  return ray;
}

// Rays farther out than this (89.4 degrees) are of no use in a plane z = 1.
constexpr double farthest_radius = 100.0;

std::optional<Eigen::Vector2d> undistort_radial_tangential(const Camera& camera, const Eigen::Vector2d& distorted) {
  if (auto ray = newton_radial_tangential(camera, distorted, distorted)) return ray;
  // Starts from the radial part alone, which can always be solved where it can be inverted.
  const double radius = distorted.norm();
  const auto radial = [&](double r) { return r * radial_part(camera, r * r).factor; };
  const auto slope = [&](double r) {
    const RadialPart part = radial_part(camera, r * r);
    return part.factor + r * r * part.slope;
  };
  const double end = growing_up_to(camera, farthest_radius);
  const auto undistorted = solve_growing(radial, slope, std::min(radius, radial(end)), end);
  if (!undistorted || radius == 0.0) return std::nullopt;
  return newton_radial_tangential(camera, distorted, distorted * (0.999 * *undistorted / radius));
}

}  // namespace

std::optional<Eigen::Vector2d> distort(const Camera& camera, const Eigen::Vector2d& ray) {
  if (camera.distortion == Distortion::none) return ray.allFinite() ? std::optional(ray) : std::nullopt;
  const auto distorted = distort_checked(camera, ray);
  if (!distorted) return std::nullopt;
  return distorted->value;
}

std::optional<Eigen::Vector2d> distort(const Camera& camera, const Eigen::Vector2d& ray, Eigen::Matrix2d& jacobian) {
  const auto distorted = distort_checked(camera, ray);
  if (!distorted) return std::nullopt;
  jacobian = distorted->jacobian;
  return distorted->value;
}

std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& distorted) {
  if (!distorted.allFinite()) return std::nullopt;
  if (camera.distortion == Distortion::none) return distorted;
  return camera.distortion == Distortion::equidistant ? undistort_equidistant(camera, distorted)
                                                      : undistort_radial_tangential(camera, distorted);
}

double monotonic_radius(const Camera& camera) {
  if (camera.distortion == Distortion::none) return std::numeric_limits<double>::infinity();
  if (camera.distortion != Distortion::equidistant) {
    const double end = growing_up_to(camera, farthest_radius);
    return end < farthest_radius ? end : std::numeric_limits<double>::infinity();
  }
  constexpr double right_angle = 0.5 * std::numbers::pi;
  const double end = growing_up_to(camera, right_angle);
  return end < right_angle ? std::tan(end) : std::numeric_limits<double>::infinity();
}

}  // namespace rastro
