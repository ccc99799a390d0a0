// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/epipolar_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rastro/slam/lsd/depth/depth_kernels.h"

namespace rastro {
namespace {

constexpr int samples = epipolar_samples, half_samples = samples / 2;

bool is_inside(GrayView image, const Eigen::Vector2d& pixel, double margin) {
  return pixel.x() >= margin && pixel.y() >= margin && pixel.x() < image.width - 1.0 - margin &&
         pixel.y() < image.height - 1.0 - margin;
}

LineSampling sampling(GrayView image, const Eigen::Vector2d& first, const Eigen::Vector2d& step, int count) {
  return {image,
          static_cast<float>(first.x()),
          static_cast<float>(first.y()),
          static_cast<float>(step.x()),
          static_cast<float>(step.y()),
          count};
}

}  // namespace

/// Of one pixel: points rotated_ + inverse_depth * translation_ in the other camera, up to scale.
struct EpipolarSearch::Line {
  Eigen::Vector3d rotated;
  Eigen::Vector2d start, along;       ///< In the other image: pixel, and direction of length 1.
  std::array<float, samples> seen{};  ///< By the keyframe along its line, as the other image would show them.
  double keyframe_step = 1.0;         ///< Pixels of the keyframe per pixel of the other image.
  double gradient = 0.0;              ///< Along the line, root mean square, per pixel of the other image.
  double cosine = 1.0;                ///< Between gradient and line in the keyframe.
};

EpipolarSearch::EpipolarSearch(GrayView keyframe, GrayView image, const Camera& camera, const SE3& image_from_keyframe,
                               double gain, double offset, const EpipolarSearchOptions& options)
    : keyframe_(keyframe),
      image_(image),
      camera_(camera),
      rotation_(image_from_keyframe.rotation().matrix()),
      translation_(image_from_keyframe.translation()),
      center_(-(rotation_.transpose() * translation_)),
      gain_(gain),
      offset_(offset),
      options_(options) {}

Eigen::Vector2d EpipolarSearch::pixel_at(const Line& line, double inverse_depth) const {
  const Eigen::Vector3d point = line.rotated + inverse_depth * translation_;
  return {camera_.fx * point.x() / point.z() + camera_.cx, camera_.fy * point.y() / point.z() + camera_.cy};
}

bool EpipolarSearch::is_masked(const Eigen::Vector2d& pixel) const {
  return !mask_.empty() && is_inside(mask_, pixel, 1.0) &&
         mask_.at(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))) == 0;
}

EpipolarMatch EpipolarSearch::find(int x, int y, const DepthPrior& prior) const {
  Line line;
  line.rotated = rotation_ * Eigen::Vector3d((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1.0);
  constexpr double least_z = 0.1;  // of the keyframe's depth
  const auto z_ratio = [&](double inverse_depth) { return line.rotated.z() + inverse_depth * translation_.z(); };
  if (!(std::min({z_ratio(prior.least), z_ratio(prior.expected), z_ratio(prior.most)}) > least_z))
    return {EpipolarResult::behind};
  line.start = pixel_at(line, prior.expected);
  if (is_masked(line.start)) return {EpipolarResult::outside};
  const Eigen::Vector2d shift = line.start - pixel_at(line, 0.0);
  const double shift_px = shift.norm();
  if (!(shift_px >= options_.min_line_px)) return {EpipolarResult::short_line};
  const double least_sigma = options_.disparity_sigma_px * prior.expected / shift_px;
  if (least_sigma * least_sigma > prior.worthwhile_variance) return {EpipolarResult::no_news};
  line.along = shift / shift_px;
  line.keyframe_step = z_ratio(prior.expected);
  if (!sample_keyframe(x, y, line)) return {EpipolarResult::flat};
  const double half = 0.5 * options_.max_length_px;
  const double far = (pixel_at(line, prior.least) - line.start).dot(line.along),
               near = (pixel_at(line, prior.most) - line.start).dot(line.along);
  const int first = static_cast<int>(std::floor(std::max(-half, far))) - 1;
  const int last = static_cast<int>(std::ceil(std::min(half, near))) + 1;
  return best_on(line, first, last, !prior.is_known);
}

/// False where the line is flat or leaves the keyframe.
bool EpipolarSearch::sample_keyframe(int x, int y, Line& line) const {
  const double ray_x = (x - camera_.cx) / camera_.fx, ray_y = (y - camera_.cy) / camera_.fy;
  // Away from the epipole the inverse depth grows, or towards it: as in the other image.
  Eigen::Vector2d along(camera_.fx * (ray_x * center_.z() - center_.x()),
                        camera_.fy * (ray_y * center_.z() - center_.y()));
  if (!(along.norm() > 1e-12)) return false;
  along.normalize();
  const Eigen::Vector2d here(x, y), reach = half_samples * line.keyframe_step * along;
  if (!is_inside(keyframe_, here + reach, 1.0) || !is_inside(keyframe_, here - reach, 1.0)) return false;
  LineIntensities intensities;
  depth_kernels().sample(sampling(keyframe_, here - reach, line.keyframe_step * along, samples), intensities);
  float squares = 0.0F;
  for (std::size_t k = 0; k < samples; ++k) {
    line.seen[k] = static_cast<float>(gain_) * intensities[k] + static_cast<float>(offset_);
    if (k > 0) squares += (line.seen[k] - line.seen[k - 1]) * (line.seen[k] - line.seen[k - 1]);
  }
  line.gradient = std::sqrt(static_cast<double>(squares) / (samples - 1));
  const Eigen::Vector2d gradient(0.5 * (keyframe_.at(x + 1, y) - keyframe_.at(x - 1, y)),
                                 0.5 * (keyframe_.at(x, y + 1) - keyframe_.at(x, y - 1)));
  line.cosine = gradient.norm() > 0.0 ? std::abs(gradient.dot(along)) / gradient.norm() : 0.0;
  constexpr double least_cosine = 0.3;
  return line.gradient >= options_.min_gradient * gain_ && line.cosine >= least_cosine;
}

/// Mean squared difference of the samples centered at `count` places, `at` pixels from the start and on; infinite
/// outside the image.
void EpipolarSearch::compare(const Line& line, double at, int count, LineCosts& costs) const {
  const auto is_seen = [&](int i) { return is_inside(image_, line.start + (at + i) * line.along, half_samples + 1.0); };
  int first = 0, end = count;
  while (first < end && !is_seen(first)) ++first;
  while (end > first && !is_seen(end - 1)) --end;
  std::fill(costs.begin(), costs.begin() + count, std::numeric_limits<float>::infinity());
  if (first == end) return;
  LineIntensities intensities;
  const Eigen::Vector2d start = line.start + (at + first - half_samples) * line.along;
  depth_kernels().sample(sampling(image_, start, line.along, end - first + samples - 1), intensities);
  LineCosts seen;
  depth_kernels().compare(intensities, line.seen, end - first, seen);
  std::copy(seen.begin(), seen.begin() + (end - first), costs.begin() + first);
}

EpipolarMatch EpipolarSearch::best_on(const Line& line, int first, int last, bool ambiguity_matters) const {
  const int count = std::min(last - first + 1, most_line_steps);
  LineCosts costs;
  compare(line, first, count, costs);
  const auto lowest = static_cast<std::size_t>(std::min_element(costs.begin(), costs.begin() + count) - costs.begin());
  const int best = static_cast<int>(lowest);
  if (!std::isfinite(costs[lowest])) return {EpipolarResult::outside};
  if (best == 0 || best + 1 == count) return {EpipolarResult::poor_match};
  const float low = costs[lowest], before = costs[lowest - 1], after = costs[lowest + 1];
  if (!std::isfinite(before) || !std::isfinite(after)) return {EpipolarResult::outside};
  const float curvature = before - 2.0F * low + after;
  const float offset = curvature > 0.0F ? std::clamp(0.5F * (before - after) / curvature, -0.5F, 0.5F) : 0.0F;
  const double at_best = static_cast<double>(first + best) + static_cast<double>(offset);
  LineCosts between;
  compare(line, at_best, 1, between);
  const auto least = static_cast<double>(std::min(between.front(), low));
  const double noise = 2.0 * options_.intensity_sigma * options_.intensity_sigma;
  if (!(least <= options_.max_residual_sigmas * options_.max_residual_sigmas * noise))
    return {EpipolarResult::poor_match};
  const auto second =
      static_cast<float>(options_.min_second_ratio * options_.min_second_ratio * (least + 0.25 * noise));
  for (int i = 0; ambiguity_matters && i < count; ++i)
    if (std::abs(i - best) > 2 && costs[static_cast<std::size_t>(i)] < second) return {EpipolarResult::ambiguous};
  return measured(line, at_best);
}

/// Along the image axis in which the point moves more.
double EpipolarSearch::inverse_depth_at(const Line& line, double at) const {
  const Eigen::Vector2d pixel = line.start + at * line.along;
  const bool across = std::abs(line.along.x()) > std::abs(line.along.y());
  const double ray = across ? (pixel.x() - camera_.cx) / camera_.fx : (pixel.y() - camera_.cy) / camera_.fy;
  const double rotated = across ? line.rotated.x() : line.rotated.y(),
               moved = across ? translation_.x() : translation_.y();
  return (rotated - ray * line.rotated.z()) / (ray * translation_.z() - moved);
}

EpipolarMatch EpipolarSearch::measured(const Line& line, double at) const {
  if (is_masked(line.start + at * line.along)) return {EpipolarResult::outside};
  const double sampling_variance = options_.disparity_sigma_px * options_.disparity_sigma_px;
  const double inverse_depth = inverse_depth_at(line, at);
  const double per_px = inverse_depth_at(line, at + 0.5) - inverse_depth_at(line, at - 0.5);
  const double geometry =
      options_.geometry_sigma_px * options_.geometry_sigma_px * (1.0 / (line.cosine * line.cosine) - 1.0 + 0.05);
  const double photometry =
      2.0 * options_.intensity_sigma * options_.intensity_sigma / (samples * line.gradient * line.gradient);
  const double variance = per_px * per_px * (geometry + photometry + sampling_variance);
  if (!(inverse_depth > 0.0) || !std::isfinite(variance)) return {EpipolarResult::behind};
  return {EpipolarResult::matched, static_cast<float>(inverse_depth), static_cast<float>(variance)};
}

}  // namespace rastro
