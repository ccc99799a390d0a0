// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/guided_search.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/feature/hamming.h"

namespace rastro {
namespace {

constexpr double min_depth = 1e-6;  ///< Minimum depth of a visible point, in the points' unit.

/// Whether the right camera's x, if known, is within the window there; NaN matches anything.
bool right_fits(const FeatureGrid& image, std::uint32_t feature, const SearchWindow& window) {
  const float right = image.right_pixel(feature);
  return !(std::abs(right - window.right) > window.radius);
}

struct Best {
  std::int64_t feature = -1;
  int distance = 257, second = 257;

  void offer(std::uint32_t candidate, int at) {
    if (at < distance) {
      second = distance;
      distance = at;
      feature = candidate;
    } else if (at < second) {
      second = at;
    }
  }
  bool passes(const MatchLimits& limits) const {
    return feature >= 0 && distance <= limits.max_distance && distance <= limits.max_ratio * second;
  }
};

}  // namespace

std::vector<FeatureMatch> match_in_windows(const FeatureGrid& image, const std::vector<SearchWindow>& windows,
                                           const MatchLimits& limits) {
  std::vector<FeatureMatch> best_of(image.size(), FeatureMatch{0, 0, 257});
  std::vector<std::uint32_t> found;
  for (const SearchWindow& window : windows) {
    image.find(window.x, window.y, window.radius, window.min_level, window.max_level, found);
    Best best;
    for (const std::uint32_t feature : found) {
      if (!right_fits(image, feature, window)) continue;
      best.offer(feature, hamming_distance(*window.descriptor, image.descriptor(feature)));
    }
    if (!best.passes(limits)) continue;
    const auto feature = static_cast<std::uint32_t>(best.feature);
    if (best.distance < best_of[feature].distance) best_of[feature] = {window.subject, feature, best.distance};
  }
  std::erase_if(best_of, [](const FeatureMatch& match) { return match.distance > 256; });
  return best_of;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> match_within_radius(const FeatureGrid& first,
                                                                         const FeatureGrid& second, float radius_px,
                                                                         const MatchLimits& limits) {
  std::vector<SearchWindow> windows;
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    const int level = first.level(i);
    if (!first.pixel(i).allFinite()) continue;
    windows.push_back({i, first.pixel(i).x(), first.pixel(i).y(), radius_px, std::nanf(""),
                       static_cast<std::uint8_t>(std::max(0, level - 1)), static_cast<std::uint8_t>(level + 1),
                       &first.descriptor(i)});
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const FeatureMatch& match : match_in_windows(second, windows, limits))
    pairs.emplace_back(match.subject, match.feature);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

GuidedSearch::GuidedSearch(const Camera& camera, const FeatureGrid& image, std::vector<float> level_radii_px,
                           const GuidedSearchOptions& options)
    : camera_(camera),
      image_(image),
      radii_(std::move(level_radii_px)),
      baseline_(options.baseline),
      log_scale_factor_(std::log(options.scale_factor)),
      min_view_cosine_(options.min_view_cosine) {
  RASTRO_CHECK(!radii_.empty(), "a radius for each level");
}

bool GuidedSearch::add_point(std::uint32_t subject, const Eigen::Vector3d& in_camera, int level,
                             const Descriptor& descriptor) {
  if (!(in_camera.z() > min_depth)) return false;
  const double inverse_depth = 1.0 / in_camera.z();
  const auto x = static_cast<float>(camera_.fx * in_camera.x() * inverse_depth + camera_.cx);
  const auto y = static_cast<float>(camera_.fy * in_camera.y() * inverse_depth + camera_.cy);
  if (!image_.holds(x, y)) return false;
  const int last = static_cast<int>(radii_.size()) - 1;
  level = std::clamp(level, 0, last);
  const float right = baseline_ > 0.0 ? static_cast<float>(x - camera_.fx * baseline_ * inverse_depth) : std::nanf("");
  windows_.push_back({subject, x, y, radii_[static_cast<std::size_t>(level)], right,
                      static_cast<std::uint8_t>(std::max(0, level - 1)),
                      static_cast<std::uint8_t>(std::min(last, level + 1)), &descriptor});
  return true;
}

bool GuidedSearch::add_landmark(std::uint32_t subject, const LandmarkAppearance& landmark,
                                const Eigen::Vector3d& in_camera, const Eigen::Vector3d& camera_center) {
  constexpr double nearer = 0.8, farther = 1.25;  // of the range of distances in which the pyramid's levels show it
  if (!(in_camera.z() > min_depth)) return false;
  const Eigen::Vector3d ray = landmark.position - camera_center;
  const double distance = ray.norm(), max_distance = static_cast<double>(landmark.max_distance);
  if (distance < nearer * static_cast<double>(landmark.min_distance) || distance > farther * max_distance) return false;
  if (ray.dot(landmark.direction) < min_view_cosine_ * distance) return false;
  const int level = static_cast<int>(std::ceil(std::log(max_distance / distance) / log_scale_factor_ - 0.5));
  return add_point(subject, in_camera, level, landmark.descriptor);
}

void GuidedSearch::add_anywhere(std::uint32_t subject, const Descriptor& descriptor) {
  constexpr float everywhere_px = 1e6F;
  windows_.push_back({subject, static_cast<float>(camera_.cx), static_cast<float>(camera_.cy), everywhere_px,
                      std::nanf(""), 0, static_cast<std::uint8_t>(radii_.size() - 1), &descriptor});
}

}  // namespace rastro
