// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/pair_depth.h"

#include "rastro/multiview/triangulation.h"
#include "rastro/sensor/stereo_pair.h"
#include "rastro/track/klt.h"

namespace rastro {
namespace {

constexpr KltOptions across{.window_px = 15, .iterations = 20, .epsilon_px = 0.02, .coarse_epsilon_px = 0.05};
constexpr double largest_error_px = 1.5, disparity_sigma_px = 0.3;
constexpr double least_parallax_deg = 0.1;

}  // namespace

std::optional<PairDepth> PairDepth::of(const SourceInfo& info) {
  if (!info.has_right || !has_calibrated_pair(info)) return std::nullopt;
  if (!(info.left_from_right->translation().norm() > 0.0)) return std::nullopt;
  return PairDepth(*info.cameras[0].camera, *info.cameras[1].camera, info.left_from_right->inverse());
}

double PairDepth::error_growth() const {
  return disparity_sigma_px / (left_.fx * right_from_left_.translation().norm());
}

std::vector<float> PairDepth::depths(const Pyramid& left, const GrayImage& right,
                                     const std::vector<Eigen::Vector2f>& pixels) {
  std::vector<float> depths(pixels.size(), 0.0F);
  if (right.width() != left.level(0).width() || right.height() != left.level(0).height()) return depths;
  right_pyramid_.build(right, left.levels(), klt_padding);
  std::vector<KltResult> results(pixels.size());
  klt_follow(left, right_pyramid_, pixels, pixels, across, nullptr, results);
  const TriangulationOptions options{
      .focal_px = left_.fx, .max_error_px = largest_error_px, .min_parallax_deg = least_parallax_deg};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!results[i].followed) continue;
    const auto a = left_.unproject(pixels[i].cast<double>()), b = right_.unproject(results[i].pixel.cast<double>());
    if (!a || !b) continue;
    if (const auto point = triangulate(right_from_left_, *a, *b, options))
      depths[i] = static_cast<float>(point->position.z());
  }
  return depths;
}

}  // namespace rastro
