// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/polynomial.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace rastro {
namespace {

/// Value and slope of a polynomial of `degree`.
std::pair<double, double> value_and_slope(const Polynomial& c, std::size_t degree, double x) {
  double value = c[degree], slope = 0.0;
  for (std::size_t i = degree; i-- > 0;) {
    slope = slope * x + value;
    value = value * x + c[i];
  }
  return {value, slope};
}

/// The root between `low` and `high`, whose values differ in sign.
double root_between(const Polynomial& c, std::size_t degree, double low, double high, bool rises) {
  double x = 0.5 * (low + high);
  for (int i = 0; i < 60; ++i) {
    const auto [value, slope] = value_and_slope(c, degree, x);
    if (value == 0.0) return x;
    ((value > 0.0) == rises ? high : low) = x;
    double next = x - value / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) <= 1e-15) return next;
    x = next;
  }
  return x;
}

/// Appends the roots within -1 and 1 of the polynomial.
void roots_within_one(const Polynomial& coefficients, std::vector<double>& out) {
  std::array<Polynomial, max_degree> derivatives;  // derivatives[d] is of degree d + 1
  derivatives[max_degree - 1] = coefficients;
  for (std::size_t d = max_degree - 1; d-- > 0;) {
    for (std::size_t i = 0; i <= d + 1; ++i) derivatives[d][i] = derivatives[d + 1][i + 1] * static_cast<double>(i + 1);
  }
  std::array<double, max_degree + 2> ends{-1.0, 1.0}, next;
  std::size_t count = 2;
  for (std::size_t degree = 1; degree <= max_degree; ++degree) {
    const Polynomial& c = derivatives[degree - 1];
    std::size_t found = 0;
    next[found++] = -1.0;
    double before = value_and_slope(c, degree, -1.0).first;
    for (std::size_t i = 1; i < count; ++i) {
      const double after = value_and_slope(c, degree, ends[i]).first;
      if (before * after < 0.0) next[found++] = root_between(c, degree, ends[i - 1], ends[i], after > 0.0);
      before = after;
    }
    next[found++] = 1.0;
    std::copy_n(next.begin(), found, ends.begin());
    count = found;
  }
  out.insert(out.end(), ends.begin() + 1, ends.begin() + static_cast<std::ptrdiff_t>(count) - 1);
}

}  // namespace

std::vector<double> cubic_roots(double c3, double c2, double c1, double c0) {
  if (std::abs(c3) < 1e-12 * (std::abs(c2) + std::abs(c1) + std::abs(c0))) {
    if (std::abs(c2) < 1e-300) return std::abs(c1) < 1e-300 ? std::vector<double>{} : std::vector<double>{-c0 / c1};
    const double discriminant = c1 * c1 - 4.0 * c2 * c0;
    if (discriminant < 0.0) return {};
    return {(-c1 + std::sqrt(discriminant)) / (2.0 * c2), (-c1 - std::sqrt(discriminant)) / (2.0 * c2)};
  }
  const double a = c2 / c3, b = c1 / c3, c = c0 / c3;
  const double q = (a * a - 3.0 * b) / 9.0, r = (2.0 * a * a * a - 9.0 * a * b + 27.0 * c) / 54.0;
  if (r * r < q * q * q) {
    const double theta = std::acos(std::clamp(r / std::sqrt(q * q * q), -1.0, 1.0));
    const double scale = -2.0 * std::sqrt(q), shift = -a / 3.0;
    return {scale * std::cos(theta / 3.0) + shift, scale * std::cos((theta + 2.0 * std::numbers::pi) / 3.0) + shift,
            scale * std::cos((theta - 2.0 * std::numbers::pi) / 3.0) + shift};
  }
  const double s = -std::copysign(std::cbrt(std::abs(r) + std::sqrt(std::max(0.0, r * r - q * q * q))), r);
  return {s + (s != 0.0 ? q / s : 0.0) - a / 3.0};
}

std::vector<double> real_roots(const Polynomial& coefficients) {
  std::vector<double> roots;
  roots_within_one(coefficients, roots);
  const std::size_t small = roots.size();
  // From the highest nonzero coefficient on: zeros above it would be roots at infinity.
  Polynomial reversed = coefficients;
  auto end = reversed.end();
  while (end != reversed.begin() && *(end - 1) == 0.0) --end;
  std::reverse(reversed.begin(), end);
  roots_within_one(reversed, roots);
  for (std::size_t i = small; i < roots.size(); ++i) roots[i] = 1.0 / roots[i];
  roots.erase(std::remove_if(roots.begin(), roots.end(), [](double x) { return !std::isfinite(x); }), roots.end());
  return roots;
}

}  // namespace rastro
