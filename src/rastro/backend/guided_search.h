// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/backend/feature_grid.h"
#include "rastro/camera/camera.h"

namespace rastro {

/// Where in an image, and at which pyramid levels, a feature is searched for.
struct SearchWindow {
  std::uint32_t subject = 0;  ///< The caller's number.
  float x = 0.0F, y = 0.0F;   ///< Predicted position, undistorted pixels.
  float radius = 0.0F;        ///< Half the side of the square.
  float right = 0.0F;         ///< Predicted x in the right camera; NaN: unknown.
  std::uint8_t min_level = 0, max_level = 0;
  const Descriptor* descriptor = nullptr;
};

struct FeatureMatch {
  std::uint32_t subject = 0, feature = 0;
  int distance = 0;
};

struct MatchLimits {
  int max_distance = 80;
  double max_ratio = 0.9;  ///< Of the best distance to the second best.
};

/// The most similar feature in each window. A feature that several subjects match goes to the most similar one (then
/// the first). Ascending by feature.
std::vector<FeatureMatch> match_in_windows(const FeatureGrid& image, const std::vector<SearchWindow>& windows,
                                           const MatchLimits& limits);

/// Mutual best matches of two images within `radius_px`; pairs ascend by the first.
std::vector<std::pair<std::uint32_t, std::uint32_t>> match_within_radius(const FeatureGrid& first,
                                                                         const FeatureGrid& second, float radius_px,
                                                                         const MatchLimits& limits);

/// The appearance of a landmark and the views it was observed from. The caller owns all members.
struct LandmarkAppearance {
  const Eigen::Vector3d& position;
  const Eigen::Vector3d& direction;                ///< Mean viewing direction, of length 1, in the position's frame.
  float min_distance = 0.0F, max_distance = 0.0F;  ///< Distances at which the coarsest and the finest level show it.
  const Descriptor& descriptor;
};

struct GuidedSearchOptions {
  double baseline = 0.0;         ///< Above 0, in the points' unit: the right camera's x must match too.
  double scale_factor = 1.2;     ///< From one pyramid level to the next.
  double min_view_cosine = 0.5;  ///< Of the angle between the mean viewing direction and the new one.
};

/// Guided matching: projects landmarks into an image and searches within a window around the predicted position, near
/// the predicted pyramid level (Mur-Artal et al. 2015, section V.D).
class GuidedSearch {
 public:
  /// `level_radii_px`: half the side of a window, one per level. Camera and image outlive this.
  GuidedSearch(const Camera& camera, const FeatureGrid& image, std::vector<float> level_radii_px,
               const GuidedSearchOptions& options);

  /// Adds a point in the camera frame that is expected at `level` plus or minus one. False, and it is not searched for,
  /// if it is behind the camera or outside the image. The descriptor must outlive the search.
  bool add_point(std::uint32_t subject, const Eigen::Vector3d& in_camera, int level, const Descriptor& descriptor);
  /// Adds a landmark at `in_camera`; its level is predicted. Also false if the camera is too near, too far or views it
  /// from too different a direction. `camera_center` is in the landmark's frame.
  bool add_landmark(std::uint32_t subject, const LandmarkAppearance& landmark, const Eigen::Vector3d& in_camera,
                    const Eigen::Vector3d& camera_center);
  /// Searches in the whole image.
  void add_anywhere(std::uint32_t subject, const Descriptor& descriptor);

  std::vector<FeatureMatch> match(const MatchLimits& limits) const {
    return match_in_windows(image_, windows_, limits);
  }

 private:
  const Camera& camera_;
  const FeatureGrid& image_;
  std::vector<float> radii_;
  double baseline_, log_scale_factor_, min_view_cosine_;
  std::vector<SearchWindow> windows_;
};

}  // namespace rastro
