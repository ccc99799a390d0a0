// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/calibrate_yaw.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/math/median.h"
#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

constexpr int iterations = 20;
constexpr double least_shift_px = 1.0;

/// Each pair's own lambda, weighted by its shift: an initial value that outliers do not affect.
double weighted_median_slope(std::span<const double> shifts, std::span<const double> yaws) {
  std::vector<std::pair<double, double>> slopes;
  double total = 0.0;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    if (shifts[i] == 0.0) continue;
    slopes.emplace_back(yaws[i] / shifts[i], std::abs(shifts[i]));
    total += std::abs(shifts[i]);
  }
  std::sort(slopes.begin(), slopes.end());
  double sum = 0.0;
  for (const auto& [slope, weight] : slopes) {
    sum += weight;
    if (2.0 * sum >= total) return slope;
  }
  return 0.0;
}

}  // namespace

YawCalibration calibrate_yaw(std::span<const double> shifts, std::span<const double> yaws) {
  RASTRO_CHECK(shifts.size() == yaws.size(), "one yaw per shift");
  const double largest = std::accumulate(shifts.begin(), shifts.end(), 0.0,
                                         [](double most, double shift) { return std::max(most, std::abs(shift)); });
  if (shifts.size() < 3 || largest < least_shift_px) {
    throw Error(
        fmt::format("{} pairs of frames with shifts up to {:.2f} px do not determine lambda", shifts.size(), largest),
        "--calibrate-yaw", "use a recording with rotations and a reference that covers them");
  }
  YawCalibration result{.lambda = weighted_median_slope(shifts, yaws)};
  for (int iteration = 0; iteration < iterations; ++iteration) {
    std::vector<double> differences(shifts.size());
    for (std::size_t i = 0; i < shifts.size(); ++i) differences[i] = std::abs(yaws[i] - result.lambda * shifts[i]);
    // 1.4826 medians are a standard deviation of normal errors.
    const double deviation = std::max(1e-12, 1.4826 * upper_median(differences));
    const TukeyKernel kernel{4.6851 * deviation};
    double squares = 0.0, products = 0.0, errors = 0.0, weights = 0.0;
    result.used = 0;
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      const double weight = kernel.weight(differences[i] * differences[i]);
      squares += weight * shifts[i] * shifts[i];
      products += weight * shifts[i] * yaws[i];
      errors += weight * differences[i] * differences[i];
      weights += weight;
      result.used += weight > 0.5 ? 1 : 0;
    }
    result.lambda = products / squares;
    result.rms_rad = std::sqrt(errors / weights);
    result.sigma = result.rms_rad / std::sqrt(squares);
  }
  return result;
}

}  // namespace rastro
