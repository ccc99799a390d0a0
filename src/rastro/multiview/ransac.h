// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

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

/// Draws needed so that one sample of `sample_size` is free of outliers with `confidence`.
inline int iterations_needed(double inlier_share, int sample_size, double confidence, int most) {
  const double clean = std::pow(inlier_share, sample_size);
  if (clean >= 1.0 - 1e-12) return 1;
  if (clean <= 1e-12) return most;
  return static_cast<int>(
      std::min(static_cast<double>(most), std::ceil(std::log(1.0 - confidence) / std::log1p(-clean))));
}

/// RANSAC (Fischler and Bolles 1981) with the truncated squared cost of MSAC (Torr and Zisserman 2000) and one
/// least-squares step on the inliers of every new best model (LO-RANSAC, Chum et al. 2003). `Problem` gives:
///   sample_size; fit(sample, sink) calls sink(model) for every model of a minimal sample; refit(model, inlier errors)
///   -> optional model; errors(model, out): squared errors of all pairs. Costs are summed in integers (1/1024 of the
///   threshold), so the order of summation does not matter. `initial`, where given, is tried before the first sample.
///   `count`: number of pairs.
template <typename Model, typename Problem>
std::optional<RobustFitOf<Model>> ransac_of(const Problem& problem, std::size_t count, const RansacOptions& options,
                                            const std::optional<Model>& initial = std::nullopt) {
  constexpr std::size_t sample_size = Problem::sample_size;
  if (count < sample_size) return std::nullopt;
  const float limit = static_cast<float>(options.max_error_px * options.max_error_px);
  const float to_units = 1024.0F / limit;
  std::vector<float> errors(count);
  const auto cost_of = [&](const Model& model) {
    problem.errors(model, errors.data());
    std::int32_t cost = 0;
    // Written so that a NaN error counts as an outlier.
    for (std::size_t i = 0; i < count; ++i) {
      const float units = errors[i] * to_units;
      cost += static_cast<std::int32_t>(units < 1024.0F ? units : 1024.0F);
    }
    return cost;
  };

  RobustFitOf<Model> best;
  std::int32_t best_cost = static_cast<std::int32_t>(count) * 1024;
  int needed = options.max_iterations;
  const auto consider = [&](const Model& model) {
    const std::int32_t cost = cost_of(model);
    if (cost >= best_cost) return false;
    best_cost = cost;
    best.model = model;
    best.squared_errors = errors;
    best.inliers = static_cast<int>(std::count_if(errors.begin(), errors.end(), [=](float e) { return e <= limit; }));
    needed = iterations_needed(static_cast<double>(best.inliers) / static_cast<double>(count),
                               static_cast<int>(sample_size), options.confidence, options.max_iterations);
    return true;
  };

  Random random(options.seed);
  int iteration = 0;
  if (initial && consider(*initial)) {
    if (const auto refined = problem.refit(best, limit)) consider(*refined);
  }
  for (; iteration < needed; ++iteration) {
    bool improved = false;
    problem.fit(draw_sample<sample_size>(random, static_cast<std::uint32_t>(count)),
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
