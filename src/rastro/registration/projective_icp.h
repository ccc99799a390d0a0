// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

struct SurfaceOptions {
  double depth_sigma_m = 0.001;       ///< Depth noise: depth_sigma_m + depth_sigma_per_m2 * depth^2.
  double depth_sigma_per_m2 = 0.002;  ///< 1/m
  double min_depth_m = 0.3, max_depth_m = 6.0;
};

constexpr int surface_block_px = 4;

/// A depth image in blocks of 4 x 4 pixels: the mean depth of each; 0 with too few measurements or with an edge in the
/// block.
struct DepthBlocks {
  int width = 0, height = 0;  ///< Blocks.
  std::vector<float> depth;   ///< Meters, row by row.

  bool empty() const { return depth.empty(); }
};

/// `mask`: blocks with a zero in it are left out; empty: none.
DepthBlocks depth_blocks(const DepthImage& depth, GrayView mask, const SurfaceOptions& options);

/// A plane through the surroundings of a block: normal . p = distance, in the depth camera; normal (0, 0, 0) for none.
struct BlockPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float distance = 0.0F;  ///< Meters, > 0.
};

/// Quadratic cost of a pose from one grid of blocks: 0.5 d^T H d - b^T d for d in pose * exp(d).
struct SurfaceFit {
  Matrix6d information = Matrix6d::Zero();  ///< H, with independent blocks.
  Vector6d gradient = Vector6d::Zero();     ///< b
  int compared = 0;                         ///< Blocks that project onto a plane of the reference.
  int fitting = 0;                          ///< Of these, within three standard deviations.
};

/// Projective point-to-plane ICP between depth images of one camera (Chen and Medioni 1992; Blais and Levine 1995;
/// projective association as in Newcombe et al. 2011, KinectFusion, section 3.5). Planes are fitted to inverse depth,
/// which is linear over the image of a plane and whose noise is uniform in a camera that measures disparity.
class ProjectiveIcp {
 public:
  /// `camera`: with its size.
  ProjectiveIcp(const Camera& camera, const SurfaceOptions& options);

  /// Planes of a reference, one per block.
  std::vector<BlockPlane> planes(const DepthBlocks& blocks) const;
  /// Cost of another image's blocks against the planes of the reference. Pairs farther apart than `reach_m` plus their
  /// noise do not count; distant ones are down-weighted (Tukey). Uses every `step`-th block of every `step`-th row.
  SurfaceFit compare(const std::vector<BlockPlane>& reference, const DepthBlocks& blocks,
                     const SE3& reference_from_blocks, double reach_m, int step) const;
  /// Overlap: share of a coarse selection of the blocks that the reference observes too, within `reach_m`; 0..1.
  double overlap(const std::vector<BlockPlane>& reference, const DepthBlocks& blocks, const SE3& reference_from_blocks,
                 double reach_m) const;

 private:
  /// The plane of the reference that a point in its camera projects onto; null for none.
  const BlockPlane* plane_at(const std::vector<BlockPlane>& reference, const Eigen::Vector3d& point) const;
  double sigma(double depth) const { return options_.depth_sigma_m + options_.depth_sigma_per_m2 * depth * depth; }
  Eigen::Vector3d point_of(const DepthBlocks& blocks, int x, int y) const;

  Camera camera_;
  SurfaceOptions options_;
  int width_, height_;                 ///< Blocks.
  std::vector<Eigen::Vector2f> rays_;  ///< Of the blocks' centers, normalized.
};

}  // namespace rastro
