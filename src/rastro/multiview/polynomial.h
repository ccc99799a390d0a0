// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace rastro {

/// Real roots of c3 x^3 + c2 x^2 + c1 x + c0, up to three.
std::vector<double> cubic_roots(double c3, double c2, double c1, double c0);

/// Highest degree that real_roots() accepts.
constexpr std::size_t max_degree = 10;

/// Coefficients from the constant on.
using Polynomial = std::array<double, max_degree + 1>;

/// Real roots in a deterministic order: between the roots of the derivative lies at most one, found by Newton steps
/// that stay within their bracket. Roots beyond 1 are those of the reversed polynomial. A double root may be missed.
std::vector<double> real_roots(const Polynomial& coefficients);

}  // namespace rastro
