// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/math/se3.h"
#include "rastro/slam/rgbd/options.h"
#include "rastro/slam/rgbd/point_ties.h"
#include "rastro/slam/rgbd/surface_check.h"

namespace rastro {

/// A keyframe and how to come by its depth, which may have to be read from a file.
struct ViewOfKeyframe {
  const ImageFeatures* keyframe = nullptr;
  std::function<std::shared_ptr<const KeyframeSurface>()> depth;
};

/// How two keyframes were found to stand to each other.
struct KeyframeTie {
  SE3 a_from_b;
  Matrix6d information = Matrix6d::Identity();  ///< As of Constraint, from a to b.
  int matches = 0, inliers = 0;
  SurfaceAgreement agreement;
};

/// Compares two keyframes: descriptors, RANSAC over what matches, and whether the surfaces contradict it. May be used
/// by several threads.
class KeyframeMatcher {
 public:
  KeyframeMatcher(const RgbdSlamOptions& options, const Camera& camera);
  /// nullopt where they have too little in common, or where depth contradicts. `guess` of a_from_b is one motion more
  /// to try.
  std::optional<KeyframeTie> match(const ViewOfKeyframe& a, const ViewOfKeyframe& b, int min_inliers,
                                   std::uint64_t seed, const std::optional<SE3>& guess) const;
  const SurfaceCheck& surfaces() const { return check_; }
  std::vector<PointTie> ties_of(const ImageFeatures& a, const ImageFeatures& b) const;

 private:
  RgbdSlamOptions options_;
  Camera camera_;
  SurfaceCheck check_;
};

DepthNoise depth_noise(const RgbdSlamOptions& options);
SurfaceOptions surface_options(const RgbdSlamOptions& options);

}  // namespace rastro
