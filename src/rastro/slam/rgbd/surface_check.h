// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/math/se3.h"
#include "rastro/registration/projective_icp.h"

namespace rastro {

/// What a keyframe's depth says, in blocks. The same from a frame as from its packed pictures.
struct KeyframeSurface {
  DepthBlocks blocks;
  std::vector<BlockPlane> planes;
};

/// What the surfaces that one view measured look like to another.
struct SurfaceAgreement {
  int agree = 0;       ///< Measured there as well.
  int contradict = 0;  ///< The other one looked through the place and saw what is behind.
  int hidden = 0;      ///< Behind what the other one saw: says nothing.
  int outside = 0;     ///< Not seen by the other one, or without depth there.

  /// Of what could be judged, the share that agrees; 0 where nothing could be.
  double share() const { return agree == 0 ? 0.0 : static_cast<double>(agree) / (agree + contradict); }
  /// Share of the measurements that could be judged.
  double overlap() const {
    return agree == 0 ? 0.0 : static_cast<double>(agree + contradict) / (agree + contradict + hidden + outside);
  }
};

/// Compares the surfaces of two keyframes. May be used by several threads.
class SurfaceCheck {
 public:
  SurfaceCheck(const Camera& camera, const SurfaceOptions& options);
  KeyframeSurface surface_of(const DepthImage& depth) const;
  /// The environment measurement check of Endres et al. 2014, section III-E, both ways.
  SurfaceAgreement compare(const KeyframeSurface& a, const KeyframeSurface& b, const SE3& a_from_b) const;
  /// What the planes of `a` say of a_from_b, for pairs within `reach_m`.
  SurfaceFit fit(const KeyframeSurface& a, const KeyframeSurface& b, const SE3& a_from_b, double reach_m) const;

 private:
  void count(const DepthBlocks& seen, const DepthBlocks& by, const SE3& by_from_seen, SurfaceAgreement& sum) const;

  Camera camera_;
  SurfaceOptions options_;
  DepthNoise noise_;
  ProjectiveIcp icp_;
  int width_ = 0, height_ = 0;         ///< Blocks.
  std::vector<Eigen::Vector2d> rays_;  ///< Of the blocks' middles, normalised; not a number where there is none.
};

}  // namespace rastro
