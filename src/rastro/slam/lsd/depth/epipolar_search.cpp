// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/epipolar_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rastro {
namespace {

constexpr int half_samples = 2, samples = 2 * half_samples + 1;

double bilinear(GrayView image, double x, double y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const double right_share = x - left, low_share = y - top;
  const std::uint8_t *above = image.row(top) + left, *below = image.row(top + 1) + left;
  const double upper = above[0] + right_share * (above[1] - above[0]);
  const double lower = below[0] + right_share * (below[1] - below[0]);
  return upper + low_share * (lower - upper);
}

bool is_inside(GrayView image, const Eigen::Vector2d& pixel, double margin) {
  return pixel.x() >= margin && pixel.y() >= margin && pixel.x() < image.width - 1.0 - margin &&
         pixel.y() < image.height - 1.0 - margin;
}

}  // namespace

/// Of one pixel: points rotated_ + inverse_depth * translation_ in the other camera, up to scale.
struct EpipolarSearch::Line {
  Eigen::Vector3d rotated;
  Eigen::Vector2d start, along;        ///< In the other image: pixel, and direction of length 1.
  std::array<double, samples> seen{};  ///< By the keyframe along its line, as the other image would show them.
  double keyframe_step = 1.0;          ///< Pixels of the keyframe per pixel of the other image.
  double gradient = 0.0;               ///< Along the line, root mean square, per pixel of the other image.
  double cosine = 1.0;                 ///< Between gradient and line in the keyframe.
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

EpipolarMatch EpipolarSearch::find(int x, int y, const DepthPrior& prior) const {
  Line line;
  line.rotated = rotation_ * Eigen::Vector3d((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1.0);
  constexpr double least_z = 0.1;  // of the keyframe's depth
  const auto z_ratio = [&](double inverse_depth) { return line.rotated.z() + inverse_depth * translation_.z(); };
  if (!(std::min({z_ratio(prior.least), z_ratio(prior.expected), z_ratio(prior.most)}) > least_z))
    return {EpipolarResult::behind};
  line.start = pixel_at(line, prior.expected);
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
  for (int k = 0; k < samples; ++k) {
    const Eigen::Vector2d at = here + (k - half_samples) * line.keyframe_step * along;
    line.seen[static_cast<std::size_t>(k)] = gain_ * bilinear(keyframe_, at.x(), at.y()) + offset_;
  }
  double squares = 0.0;
  for (std::size_t k = 1; k < samples; ++k)
    squares += (line.seen[k] - line.seen[k - 1]) * (line.seen[k] - line.seen[k - 1]);
  line.gradient = std::sqrt(squares / (samples - 1));
  const Eigen::Vector2d gradient(0.5 * (keyframe_.at(x + 1, y) - keyframe_.at(x - 1, y)),
                                 0.5 * (keyframe_.at(x, y + 1) - keyframe_.at(x, y - 1)));
  line.cosine = gradient.norm() > 0.0 ? std::abs(gradient.dot(along)) / gradient.norm() : 0.0;
  constexpr double least_cosine = 0.3;
  return line.gradient >= options_.min_gradient * gain_ && line.cosine >= least_cosine;
}

/// Mean squared difference of the samples centered `at` pixels from the start; infinite outside the image.
double EpipolarSearch::residual(const Line& line, double at) const {
  const Eigen::Vector2d middle = line.start + at * line.along;
  if (!is_inside(image_, middle, half_samples + 1.0)) return std::numeric_limits<double>::infinity();
  double squares = 0.0;
  for (int k = 0; k < samples; ++k) {
    const Eigen::Vector2d pixel = middle + (k - half_samples) * line.along;
    const double difference = bilinear(image_, pixel.x(), pixel.y()) - line.seen[static_cast<std::size_t>(k)];
    squares += difference * difference;
  }
  return squares / samples;
}

EpipolarMatch EpipolarSearch::best_on(const Line& line, int first, int last, bool ambiguity_matters) const {
  constexpr int most_steps = 64;
  std::array<double, most_steps> costs{};
  const int count = std::min(last - first + 1, most_steps);
  int best = -1;
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(i);
    costs[index] = residual(line, first + i);
    if (std::isfinite(costs[index]) && (best < 0 || costs[index] < costs[static_cast<std::size_t>(best)])) best = i;
  }
  if (best < 0) return {EpipolarResult::outside};
  if (best == 0 || best + 1 == count) return {EpipolarResult::poor_match};
  const auto lowest = static_cast<std::size_t>(best);
  const double low = costs[lowest], before = costs[lowest - 1], after = costs[lowest + 1];
  if (!std::isfinite(before) || !std::isfinite(after)) return {EpipolarResult::outside};
  const double noise = 2.0 * options_.intensity_sigma * options_.intensity_sigma;
  const double curvature = before - 2.0 * low + after;
  const double offset = curvature > 0.0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
  const double at_best = residual(line, first + best + offset);
  if (!(std::min(at_best, low) <= options_.max_residual_sigmas * options_.max_residual_sigmas * noise))
    return {EpipolarResult::poor_match};
  const double second = options_.min_second_ratio * options_.min_second_ratio * (std::min(at_best, low) + 0.25 * noise);
  for (int i = 0; ambiguity_matters && i < count; ++i)
    if (std::abs(i - best) > 2 && costs[static_cast<std::size_t>(i)] < second) return {EpipolarResult::ambiguous};
  return measured(line, first + best + offset);
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
