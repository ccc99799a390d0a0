// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/backend/feature_grid.h"
#include "rastro/camera/camera.h"

namespace rastro {

/// Where in an image, and at which levels of the pyramid, a feature is searched for.
struct SearchWindow {
  std::uint32_t subject = 0;  ///< The caller's own number.
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

/// The most similar feature in each window; a feature goes to the subject it is most similar to (then the first).
/// Ascending by feature.
std::vector<FeatureMatch> match_in_windows(const FeatureGrid& image, const std::vector<SearchWindow>& windows,
                                           const MatchLimits& limits);

/// Features of two images that are each other's most similar within `radius_px`; pairs ascend by the first.
std::vector<std::pair<std::uint32_t, std::uint32_t>> match_within_radius(const FeatureGrid& first,
                                                                         const FeatureGrid& second, float radius_px,
                                                                         const MatchLimits& limits);

/// From where a landmark was seen, and as what. All are the caller's.
struct LandmarkAppearance {
  const Eigen::Vector3d& position;
  const Eigen::Vector3d& direction;                ///< Mean viewing direction, of length 1, in the position's frame.
  float min_distance = 0.0F, max_distance = 0.0F;  ///< At which the coarsest and the finest level show it.
  const Descriptor& descriptor;
};

struct GuidedSearchOptions {
  double baseline = 0.0;         ///< Above 0, and in the points' unit: the right camera's x has to fit too.
  double scale_factor = 1.2;     ///< From one level of the pyramid to the next.
  double min_view_cosine = 0.5;  ///< Of the angle between the mean viewing direction and the new one.
};

/// Guided matching: landmarks are projected into an image and searched for within a window about their predicted
/// position, at about their predicted level (Mur-Artal et al. 2015, section V.D).
class GuidedSearch {
 public:
  /// `level_radii_px`: half the side of a window, one a level. Camera and image outlive this.
  GuidedSearch(const Camera& camera, const FeatureGrid& image, std::vector<float> level_radii_px,
               const GuidedSearchOptions& options);

  /// A point in the camera's frame that should show at `level`, give or take one. False, and it is not searched for,
  /// where it lies behind the camera or outside the image. The descriptor must outlive the search.
  bool add_point(std::uint32_t subject, const Eigen::Vector3d& in_camera, int level, const Descriptor& descriptor);
  /// A landmark which lies at `in_camera`; its level is predicted. False as well where it is seen from too near, too
  /// far or too different a direction. `camera_center` is in the landmark's frame.
  bool add_landmark(std::uint32_t subject, const LandmarkAppearance& landmark, const Eigen::Vector3d& in_camera,
                    const Eigen::Vector3d& camera_center);
  /// Searched for in the whole image.
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
