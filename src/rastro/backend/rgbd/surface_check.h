// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "rastro/backend/acceptance.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/math/se3.h"
#include "rastro/registration/projective_icp.h"

namespace rastro {

/// The surfaces in a keyframe's depth image, in blocks. The same from a frame as from its packed images.
struct KeyframeSurface {
  DepthBlocks blocks;
  std::vector<BlockPlane> planes;
};

/// How the surfaces measured in one view compare with another view.
struct SurfaceAgreement {
  int agree = 0;       ///< Measured at the same depth there.
  int contradict = 0;  ///< The other view measured a surface behind it: it looked through this one.
  int hidden = 0;      ///< Occluded in the other view: no evidence.
  int outside = 0;     ///< Outside the other view, or without depth there.

  /// A surface that the other view looked through should have been visible: negative evidence. Does not include
  /// matches.
  Evidence evidence() const {
    const int judged = agree + contradict;
    return {.compared = judged + hidden + outside, .predicted = judged, .observed = agree};
  }
};

/// Compares the surfaces of two keyframes. Thread-safe.
class SurfaceCheck {
 public:
  SurfaceCheck(const Camera& camera, const SurfaceOptions& options);
  KeyframeSurface surface_of(const DepthImage& depth) const;
  /// The same of a depth image that was packed, which is rounded already.
  KeyframeSurface surface_of_unpacked(const DepthImage& depth) const;
  /// Of one keyframe's.
  std::size_t bytes() const { return rays_.size() * (sizeof(float) + sizeof(BlockPlane)); }
  /// The environment measurement check of Endres et al. 2014, section III-E, in both directions.
  SurfaceAgreement compare(const KeyframeSurface& a, const KeyframeSurface& b, const SE3& a_from_b) const;
  /// Constraint on a_from_b from the planes of `a`, for pairs within `reach_m`.
  SurfaceFit fit(const KeyframeSurface& a, const KeyframeSurface& b, const SE3& a_from_b, double reach_m) const;

 private:
  void count(const DepthBlocks& seen, const DepthBlocks& by, const SE3& by_from_seen, SurfaceAgreement& sum) const;

  Camera camera_;
  SurfaceOptions options_;
  DepthNoise noise_;
  ProjectiveIcp icp_;
  int width_ = 0, height_ = 0;         ///< Blocks.
  std::vector<Eigen::Vector2d> rays_;  ///< Of the block centers, normalized; NaN where there is none.
};

}  // namespace rastro
