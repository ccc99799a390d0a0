// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Draws `Count` different numbers below `size`; size >= Count.
template <std::size_t Count>
std::array<std::uint32_t, Count> draw_sample(Random& random, std::uint32_t size) {
  std::array<std::uint32_t, Count> sample{};
  for (std::size_t i = 0; i < Count; ++i) {
    do {
      sample[i] = random.below(size);
    } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
  }
  return sample;
}

/// Draws numbers below the size of `weights`, each with the probability of its weight.
class WeightedDraw {
 public:
  explicit WeightedDraw(std::span<const std::int32_t> weights) : sums_(weights.size()) {
    std::partial_sum(weights.begin(), weights.end(), sums_.begin(),
                     [](std::int32_t sum, std::int32_t weight) { return sum + std::max(weight, 1); });
  }
  /// `Count` different ones; as many weights at least.
  template <std::size_t Count>
  std::array<std::uint32_t, Count> sample(Random& random) const {
    std::array<std::uint32_t, Count> sample{};
    for (std::size_t i = 0; i < Count; ++i) {
      do {
        const auto at = static_cast<std::int32_t>(random.below(static_cast<std::uint32_t>(sums_.back())));
        sample[i] = static_cast<std::uint32_t>(std::upper_bound(sums_.begin(), sums_.end(), at) - sums_.begin());
      } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
    }
    return sample;
  }

 private:
  std::vector<std::int32_t> sums_;  ///< Of the weights so far.
};

/// Draws needed so that one sample of `sample_size` is free of outliers with `confidence`.
inline int iterations_needed(double inlier_share, int sample_size, double confidence, int most) {
  const double clean = std::pow(inlier_share, sample_size);
  if (clean >= 1.0 - 1e-12) return 1;
  if (clean <= 1e-12) return most;
  return static_cast<int>(
      std::min(static_cast<double>(most), std::ceil(std::log(1.0 - confidence) / std::log1p(-clean))));
}

/// The truncated squared cost of MSAC in integers (1/1024 of the threshold), so that the order of summation does not
/// matter, weighted where `weights` is not empty.
struct TruncatedCost {
  float limit = 0.0F;  ///< Of squared errors.
  std::span<const std::int32_t> weights;

  std::int64_t weight(std::size_t i) const { return weights.empty() ? 1 : weights[i]; }
  /// Of the errors within the limit.
  std::int64_t fitting(const std::vector<float>& errors) const {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) sum += errors[i] <= limit ? weight(i) : 0;
    return sum;
  }
  std::int64_t all(std::size_t count) const {
    return weights.empty() ? static_cast<std::int64_t>(count)
                           : std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
  }
  std::int64_t of(const std::vector<float>& errors) const {
    const float to_units = 1024.0F / limit;
    // Written so that a NaN error counts as an outlier.
    const auto units_of = [=](float error) {
      const float units = error * to_units;
      return static_cast<std::int32_t>(units < 1024.0F ? units : 1024.0F);
    };
    if (weights.empty()) {  // four at a time
      std::int32_t sum = 0;
      for (const float error : errors) sum += units_of(error);
      return sum;
    }
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) sum += std::int64_t{weights[i]} * units_of(errors[i]);
    return sum;
  }
};

/// RANSAC (Fischler and Bolles 1981) with the truncated squared cost of MSAC (Torr and Zisserman 2000) and one
/// least-squares step on the inliers of every new best model (LO-RANSAC, Chum et al. 2003). `Problem` gives:
///   sample_size; fit(sample, sink) calls sink(model) for every model of a minimal sample; refit(model, inlier errors)
///   -> optional model; errors(model, out): squared errors of all pairs. `initial`, where given, is tried before the
///   first sample.
///   `count`: number of pairs. `weights`, where not empty: how much the cost of each pair counts and how often it is
///   drawn, 1 to 1000.
template <typename Model, typename Problem>
std::optional<RobustFitOf<Model>> ransac_of(const Problem& problem, std::size_t count, const RansacOptions& options,
                                            const std::optional<Model>& initial = std::nullopt,
                                            std::span<const std::int32_t> weights = {}) {
  constexpr std::size_t sample_size = Problem::sample_size;
  if (count < sample_size) return std::nullopt;
  const float limit = static_cast<float>(options.max_error_px * options.max_error_px);
  const TruncatedCost cost{limit, weights};
  std::vector<float> errors(count);
  RobustFitOf<Model> best;
  std::int64_t best_cost = 1024 * cost.all(count);
  int needed = options.max_iterations;
  const auto consider = [&](const Model& model) {
    problem.errors(model, errors.data());
    const std::int64_t model_cost = cost.of(errors);
    if (model_cost >= best_cost) return false;
    best_cost = model_cost;
    best.model = model;
    best.squared_errors = errors;
    best.inliers = static_cast<int>(std::count_if(errors.begin(), errors.end(), [=](float e) { return e <= limit; }));
    const double share = static_cast<double>(cost.fitting(errors)) / static_cast<double>(cost.all(count));
    needed =
        std::max(std::min(options.min_iterations, options.max_iterations),
                 iterations_needed(share, static_cast<int>(sample_size), options.confidence, options.max_iterations));
    return true;
  };

  Random random(options.seed);
  const WeightedDraw weighted(weights);
  int iteration = 0;
  if (initial && consider(*initial)) {
    if (const auto refined = problem.refit(best, limit)) consider(*refined);
  }
  for (; iteration < needed; ++iteration) {
    bool improved = false;
    problem.fit(weights.empty() ? draw_sample<sample_size>(random, static_cast<std::uint32_t>(count))
                                : weighted.template sample<sample_size>(random),
                [&](const Model& model) { improved |= consider(model); });
    if (!improved) continue;
    if (const auto refined = problem.refit(best, limit)) consider(*refined);
  }
  if (best.squared_errors.empty()) return std::nullopt;
  if (const auto refined = problem.refit(best, limit)) consider(*refined);
  best.iterations = iteration;
  return best;
}

template <typename Problem>
std::optional<RobustFit> ransac(const Problem& problem, const PointPairs& pairs, const RansacOptions& options) {
  return ransac_of<Eigen::Matrix3d>(problem, pairs.size(), options);
}

}  // namespace rastro
