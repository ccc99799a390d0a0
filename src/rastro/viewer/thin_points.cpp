// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/thin_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr int axes = 3;
constexpr double cells_per_axis = 2'000'000;  // 21 bits of a key each

struct Bounds {
  std::array<float, axes> low{}, high{};
  double longest() const {
    double side = 0.0;
    for (std::size_t axis = 0; axis < axes; ++axis)
      side = std::max(side, static_cast<double>(high[axis]) - static_cast<double>(low[axis]));
    return side;
  }
};

Bounds bounds_of(std::span<const float> positions, std::span<const std::uint32_t> indices) {
  Bounds bounds;
  bounds.low.fill(std::numeric_limits<float>::max());
  bounds.high.fill(std::numeric_limits<float>::lowest());
  for (const std::uint32_t index : indices) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const float value = positions[axes * std::size_t{index} + axis];
      bounds.low[axis] = std::min(bounds.low[axis], value);
      bounds.high[axis] = std::max(bounds.high[axis], value);
    }
  }
  return bounds;
}

std::vector<std::uint32_t> finite_points(std::span<const float> positions) {
  std::vector<std::uint32_t> indices;
  for (std::size_t k = 0; axes * k < positions.size(); ++k) {
    const auto point = positions.subspan(axes * k, axes);
    if (std::all_of(point.begin(), point.end(), [](float each) { return std::isfinite(each); }))
      indices.push_back(static_cast<std::uint32_t>(k));
  }
  return indices;
}

/// The first point of each cube, ascending.
std::vector<std::uint32_t> first_of_cubes(std::span<const float> positions, std::span<const std::uint32_t> indices,
                                          const Bounds& bounds, double side) {
  constexpr int bits_per_axis = 21;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
  keyed.reserve(indices.size());
  for (const std::uint32_t index : indices) {
    std::uint64_t key = 0;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const double along = static_cast<double>(positions[axes * std::size_t{index} + axis]) - bounds.low[axis];
      key = (key << bits_per_axis) | static_cast<std::uint64_t>(along / side);
    }
    keyed.emplace_back(key, index);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < keyed.size(); ++k)
    if (k == 0 || keyed[k].first != keyed[k - 1].first) kept.push_back(keyed[k].second);
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace

std::vector<std::uint32_t> thin_points(std::span<const float> positions, double side, std::size_t most) {
  RASTRO_CHECK(positions.size() % axes == 0 && most > 0, "whole points, and some of them");
  std::vector<std::uint32_t> kept = finite_points(positions);
  if (kept.empty() || (side <= 0.0 && kept.size() <= most)) return kept;
  const Bounds bounds = bounds_of(positions, kept);
  const double least_side = std::max(bounds.longest() / cells_per_axis, 1e-9);
  side = std::max(side, least_side);
  kept = first_of_cubes(positions, kept, bounds, side);
  // Each raster is filled from what the finer one before left: fewer points to sort each time.
  while (kept.size() > most) {
    // Points lie on surfaces: their number falls with the square of the side.
    const double too_many = static_cast<double>(kept.size()) / static_cast<double>(most);
    side *= std::clamp(0.9 * std::sqrt(too_many), 1.03, 8.0);
    kept = first_of_cubes(positions, kept, bounds, side);
  }
  return kept;
}

}  // namespace rastro
