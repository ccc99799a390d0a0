// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/map/images/depth_surface.h"
#include "rastro/map/mesh/build_mesh.h"
#include "rastro/math/se3.h"

namespace rastro::detail {

constexpr int block_side = 8;
constexpr int block_cells = block_side * block_side * block_side;

/// Signed distance to the surface at a voxel's center: positive in front of it, on the cameras' side.
struct DistanceVoxel {
  float distance = 0.0F;  ///< Weighted mean, meters.
  float weight = 0.0F;
  std::array<std::uint8_t, 3> color{};
  std::uint8_t views = 0;  ///< Saturates at 255.
};

using BlockIndex = Eigen::Vector3i;  ///< In blocks.

struct DistanceBlock {
  BlockIndex index = BlockIndex::Zero();
  std::array<DistanceVoxel, block_cells> voxels;
};

/// Blocks of voxels near surfaces.
class DistanceVolume {
 public:
  explicit DistanceVolume(const MeshOptions& options);
  /// Adds one keyframe's measurements, one sample per pixel. Error if there would be too many blocks.
  void add(const std::vector<SurfaceSample>& samples, const Camera& camera, int width, int height,
           const SE3& world_from_camera, TaskPool* pool);
  /// Sorts the blocks by position; to be called last.
  void sort();

  double voxel_m() const { return voxel_m_; }
  const std::vector<std::unique_ptr<DistanceBlock>>& blocks() const { return blocks_; }
  /// Index of a block; -1 where there is none.
  int block_at(const BlockIndex& index) const;

 private:
  struct View;
  static std::uint64_t key_of(const BlockIndex& index);
  std::vector<int> touch(const std::vector<SurfaceSample>& samples, const SE3& world_from_camera);
  void update(DistanceBlock& block, const View& view) const;

  double voxel_m_, truncation_m_;
  std::size_t max_blocks_;
  std::vector<std::unique_ptr<DistanceBlock>> blocks_;
  std::unordered_map<std::uint64_t, int> index_;  ///< Only looked up, so its order does not matter.
};

}  // namespace rastro::detail
