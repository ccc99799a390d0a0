// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/local_motion.h"

#include <algorithm>
#include <complex>
#include <numeric>

namespace rastro {
namespace {

constexpr std::size_t neighbors = 12;
constexpr int least_support = 4;
// Two points closer than this give no reliable rotation and scale.
constexpr double least_base_px = 15.0;
constexpr double most_scale = 2.0;

// Points of the plane as complex numbers: a similarity is z -> factor * z + shift.
using Complex = std::complex<double>;

struct Pair {
  Complex a, b;
};

std::vector<Pair> nearest_pairs(const PointPairs& pairs, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) { return (pairs.a(i) - a).norm() < 0.5 && (pairs.b(i) - b).norm() < 0.5; });
  const auto nearer = [&](std::size_t i, std::size_t j) {
    const double di = (pairs.a(i) - a).squaredNorm(), dj = (pairs.a(j) - a).squaredNorm();
    return di != dj ? di < dj : i < j;
  };
  const std::size_t kept = std::min(neighbors, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end(), nearer);
  std::vector<Pair> nearest;
  for (std::size_t i = 0; i < kept; ++i) {
    const Eigen::Vector2d pa = pairs.a(order[i]), pb = pairs.b(order[i]);
    nearest.push_back({{pa.x(), pa.y()}, {pb.x(), pb.y()}});
  }
  return nearest;
}

}  // namespace

bool agrees_with_neighbors(const PointPairs& pairs, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                           double max_error) {
  const std::vector<Pair> nearest = nearest_pairs(pairs, a, b);
  const Complex from(a.x(), a.y()), to(b.x(), b.y());
  int best_support = 0;
  double best_error = 0.0;
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    for (std::size_t j = i + 1; j < nearest.size(); ++j) {
      const Complex base = nearest[j].a - nearest[i].a;
      if (std::abs(base) < least_base_px) continue;
      const Complex factor = (nearest[j].b - nearest[i].b) / base;
      if (std::abs(factor) > most_scale || std::abs(factor) < 1.0 / most_scale) continue;
      const Complex shift = nearest[i].b - factor * nearest[i].a;
      const auto error_of = [&](const Pair& pair) { return std::abs(factor * pair.a + shift - pair.b); };
      const int support = static_cast<int>(
          std::count_if(nearest.begin(), nearest.end(), [&](const Pair& pair) { return error_of(pair) <= max_error; }));
      const double error = std::abs(factor * from + shift - to);
      // Of motions with equally many inliers the one that fits the point best is used.
      if (support > best_support || (support == best_support && error < best_error)) {
        best_support = support;
        best_error = error;
      }
    }
  }
  return best_support >= least_support && best_error <= max_error;
}

}  // namespace rastro
