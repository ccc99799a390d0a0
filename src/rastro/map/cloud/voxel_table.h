// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "rastro/base/task_pool.h"

namespace rastro::detail {

/// A measurement in the world.
struct WorldSample {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< Zero: unknown.
  Eigen::Vector3f ray = Eigen::Vector3f::Zero();     ///< From the camera to the point, 1 m along the optical axis.
  float sigma = 0.0F;                                ///< Of the depth, meters.
  std::array<std::uint8_t, 3> color{};
};

/// Sums over the measurements in a voxel. Positions are relative to the voxel's lowest corner.
struct Voxel {
  std::uint64_t key = 0;
  float weight = 0.0F;                ///< Sum of w = 1 / sigma^2.
  float variance = 0.0F;              ///< Sum of w^2 times the variance along the normal.
  float along = 0.0F, along2 = 0.0F;  ///< Sums of w d and w d^2, d = the position along its own normal.
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< Sum of w times position.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    ///< Sum of w times normal.
  Eigen::Vector3f color = Eigen::Vector3f::Zero();     ///< Sum of w times color.
  std::uint32_t count = 0, views = 0;                  ///< Number of measurements, and of keyframes they came from.
  std::int32_t last_view = -1;
};

/// Voxels indexed by position, in shards that threads fill in parallel. The contents depend only on what was added and
/// in which order.
class VoxelTable {
 public:
  static constexpr int shard_count = 16;

  explicit VoxelTable(double side_m) : side_m_(side_m), shards_(shard_count) {}

  double side_m() const { return side_m_; }
  std::size_t size() const;
  /// The key of the voxel at a position; 0 if it is too far away to have a key.
  std::uint64_t key_of(const Eigen::Vector3d& position) const;
  Eigen::Vector3d corner_of(std::uint64_t key) const;
  static int shard_of(std::uint64_t key) { return static_cast<int>(hash_of(key) >> 60); }
  const std::vector<Voxel>& shard(int index) const { return shards_[static_cast<std::size_t>(index)].voxels; }
  const Voxel* find(std::uint64_t key) const;
  /// Threads may add to different shards at once; `key` belongs to the sample and is not 0.
  void add(std::uint64_t key, const WorldSample& sample, std::int32_t view);
  /// Doubles the side of the voxels.
  void coarsen();

 private:
  struct Shard {
    /// Index into voxels + 1, or 0, below bits of the hash that avoid most accesses to voxels; a power of two of them.
    std::vector<std::uint64_t> slots;
    std::vector<Voxel> voxels;
  };
  static std::uint64_t hash_of(std::uint64_t key) {
    key = (key ^ (key >> 31)) * 0x9E3779B97F4A7C15ULL;
    return (key ^ (key >> 29)) * 0xBF58476D1CE4E5B9ULL;
  }
  static void grow(Shard& shard);
  Voxel& voxel_at(std::uint64_t key);

  double side_m_;
  std::vector<Shard> shards_;
};

}  // namespace rastro::detail
