// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/depth_scale_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr double disparity_step_px = 0.125, pattern_baseline_m = 0.075;  // Of the cameras by PrimeSense.
// Their proportions: 57 to 64 degrees wide, 4:3.
constexpr double narrowest_focal = 0.79, widest_focal = 0.94, aspect = 0.75;  // Focal length by width.
constexpr double least_ratio = 0.62, largest_ratio = 1.6;                     // Of right depths.
constexpr std::size_t least_images = 3, fewest_steps = 30;
constexpr float bin_m = 1e-4F, farthest_m = 40.0F;
constexpr double least_growth = 1.25, half_tolerance = 0.1, step_tolerance = 0.25, least_alike_share = 0.6;

bool is_pattern_camera(const Camera& camera) {
  const double focal = camera.fx / camera.width;
  return std::abs(static_cast<double>(camera.height) / camera.width - aspect) < 0.02 && focal > narrowest_focal &&
         focal < widest_focal;
}

/// The depths that occur, in units of a bin, ascending.
std::vector<int> depths_of(const DepthImage& depth) {
  std::vector<char> occurs(static_cast<std::size_t>(farthest_m / bin_m) + 1, 0);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const float z = depth.at(x, y);
      if (z > 0.0F && z < farthest_m) occurs[static_cast<std::size_t>(std::lround(z / bin_m))] = 1;
    }
  std::vector<int> depths;
  for (std::size_t i = 0; i < occurs.size(); ++i)
    if (occurs[i] != 0) depths.push_back(static_cast<int>(i));
  return depths;
}

}  // namespace

std::optional<double> depth_steps(const DepthImage& depth) {
  const std::vector<int> depths = depths_of(depth);
  if (depths.size() < fewest_steps) return std::nullopt;
  std::vector<double> steps, middles;
  for (std::size_t i = 1; i < depths.size(); ++i) {
    middles.push_back(0.5 * static_cast<double>(bin_m) * (depths[i] + depths[i - 1]));
    steps.push_back(static_cast<double>(bin_m) * (depths[i] - depths[i - 1]) / (middles.back() * middles.back()));
  }
  const auto half = static_cast<std::ptrdiff_t>(steps.size() / 2);
  const double near = median({steps.begin(), steps.begin() + half}), far = median({steps.begin() + half, steps.end()});
  // Steps that are the same everywhere, such as whole millimeters, would differ by this factor.
  const double growth =
      median({middles.begin() + half, middles.end()}) / median({middles.begin(), middles.begin() + half});
  if (growth * growth < least_growth || std::abs(far / near - 1.0) > half_tolerance) return std::nullopt;
  const auto same =
      std::count_if(steps.begin(), steps.end(), [&](double s) { return std::abs(s - far) < step_tolerance * far; });
  if (static_cast<double>(same) < least_alike_share * static_cast<double>(steps.size())) return std::nullopt;
  return far;
}

DepthScaleCheck::DepthScaleCheck(const std::optional<Camera>& camera) : schedule_(0, 5.0, 1.3, 300.0) {
  if (camera && is_pattern_camera(*camera)) {
    // Of their depth image, which is 640 wide whatever the size of the color image.
    expected_ = disparity_step_px / (640.0 / camera->width * camera->fx * pattern_baseline_m);
  }
}

void DepthScaleCheck::add(const Frame& frame, InputWarnings& found) {
  const std::int64_t number = number_++;
  if (!expected_ || said_ || frame.depth.empty() || !schedule_.is_due(number)) return;
  schedule_.taken(number);
  const auto steps = depth_steps(frame.depth);
  if (!steps) return;
  measured_.push_back(*steps);
  if (measured_.size() < least_images) return;
  const double k = median(measured_), ratio = k / *expected_;
  if (ratio > least_ratio && ratio < largest_ratio) return;
  said_ = true;
  found.push_back(
      {"depth_scale",
       fmt::format("the depth seems to be {:.2g} times what it is: its steps are {:.1f} mm at 2 m, and those "
                   "of a Kinect or Xtion, whose field of view this camera has, are {:.1f} mm; check the "
                   "depth factor (units a meter)",
                   1.0 / ratio, 4000.0 * k, 4000.0 * *expected_)});
}

}  // namespace rastro
