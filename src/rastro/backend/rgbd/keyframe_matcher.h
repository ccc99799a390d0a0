// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "rastro/backend/rgbd/options.h"
#include "rastro/backend/rgbd/surface_check.h"
#include "rastro/backend/rgbd/two_view_points.h"
#include "rastro/camera/camera.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/math/se3.h"

namespace rastro {

/// A keyframe and a function that provides its depth, which may have to be read from a file.
struct ViewOfKeyframe {
  const ImageFeatures* keyframe = nullptr;
  std::function<std::shared_ptr<const KeyframeSurface>()> depth;
};

/// The estimated relative pose of two keyframes.
struct KeyframeConstraint {
  SE3 a_from_b;
  Matrix6d information = Matrix6d::Identity();  ///< As of Constraint, from a to b.
  int matches = 0, inliers = 0;
  SurfaceAgreement agreement;

  Evidence evidence() const;  ///< Of features and surfaces.
};

/// Inflation of a match's covariance, as of tracking's: errors of neighboring features and depths are correlated.
constexpr double match_covariance_factor = 4.0;

enum class MatchScope : std::uint8_t {
  anywhere,    ///< The relative pose that most matches agree with.
  near_guess,  ///< Only what agrees with the guess.
};

/// Of the position: a place seen again that says less is not worth the risk.
constexpr double most_revisit_sigma_m = 0.2;

/// How two keyframes are compared.
struct MatchRequest {
  int min_inliers = 25;           ///< That a constraint from features alone needs.
  std::uint64_t seed = 1;         ///< Of RANSAC.
  std::optional<SE3> guess = {};  ///< Of a_from_b: one more hypothesis.
  MatchScope scope = MatchScope::anywhere;
  bool far = false;  ///< Features without a depth count as well, by their direction.
  double max_sigma_m = std::numeric_limits<double>::infinity();  ///< Of the position, in its least certain direction.
};

/// Compares two keyframes: descriptor matching, RANSAC over the matches, and whether the surfaces contradict the
/// result. Thread-safe.
class KeyframeMatcher {
 public:
  KeyframeMatcher(const RgbdSlamOptions& options, const Camera& camera);
  /// nullopt where the keyframes have too little in common, or where depth contradicts. `why`, if any, receives what
  /// was lacking, or none.
  std::optional<KeyframeConstraint> match(const ViewOfKeyframe& a, const ViewOfKeyframe& b, const MatchRequest& request,
                                          Rejection* why = nullptr) const;
  const SurfaceCheck& surfaces() const { return check_; }
  std::vector<PointMatch> matches_of(const ImageFeatures& a, const ImageFeatures& b, bool far = false) const;

 private:
  RgbdSlamOptions options_;
  Camera camera_;
  SurfaceCheck check_;
};

DepthNoise depth_noise(const RgbdSlamOptions& options);
SurfaceOptions surface_options(const RgbdSlamOptions& options);

}  // namespace rastro
