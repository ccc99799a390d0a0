// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/calibrate_yaw.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

constexpr int iterations = 20;
constexpr double least_shift_px = 1.0;

struct Weighted {
  double value, weight;
};

double weighted_median(std::vector<Weighted> values) {
  std::sort(values.begin(), values.end(), [](const Weighted& a, const Weighted& b) { return a.value < b.value; });
  double total = 0.0, sum = 0.0;
  for (const Weighted& each : values) total += each.weight;
  for (const Weighted& each : values) {
    sum += each.weight;
    if (2.0 * sum >= total) return each.value;
  }
  return 0.0;
}

/// Each pair's own lambda, weighted by its shift: an initial value that outliers do not affect.
double weighted_median_slope(std::span<const double> shifts, std::span<const double> yaws) {
  std::vector<Weighted> slopes;
  for (std::size_t i = 0; i < shifts.size(); ++i)
    if (shifts[i] != 0.0) slopes.push_back({yaws[i] / shifts[i], std::abs(shifts[i])});
  return weighted_median(std::move(slopes));
}

/// Standard deviation of the residuals. Frames in which the camera stands still say nothing about it, however many.
double deviation_of(std::span<const double> shifts, std::span<const double> differences) {
  std::vector<Weighted> weighted;
  for (std::size_t i = 0; i < shifts.size(); ++i) weighted.push_back({differences[i], std::abs(shifts[i])});
  // 1.4826 medians are a standard deviation of normal errors.
  return std::max(1e-12, 1.4826 * weighted_median(std::move(weighted)));
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
    const TukeyKernel kernel{4.6851 * deviation_of(shifts, differences)};
    double squares = 0.0, products = 0.0, errors = 0.0, weights = 0.0, squared_products = 0.0;
    result.used = 0;
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      const double weight = kernel.weight(differences[i] * differences[i]);
      squares += weight * shifts[i] * shifts[i];
      products += weight * shifts[i] * yaws[i];
      errors += weight * differences[i] * differences[i];
      squared_products += weight * shifts[i] * shifts[i] * differences[i] * differences[i];
      weights += weight;
      result.used += weight > 0.5 ? 1 : 0;
    }
    result.lambda = products / squares;
    result.rms_rad = std::sqrt(errors / weights);
    result.sigma = std::sqrt(squared_products) / squares;
  }
  return result;
}

}  // namespace rastro
