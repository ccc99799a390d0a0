// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/cloud/voxel_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rastro::detail {
namespace {

constexpr std::int64_t half_range = 1 << 20;
constexpr int bits = 21;
constexpr std::uint64_t coordinate_mask = (1ULL << bits) - 1;

std::uint64_t packed(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto biased = [](std::int64_t value) { return static_cast<std::uint64_t>(value + half_range); };
  return biased(z) << (2 * bits) | biased(y) << bits | biased(x);
}

constexpr std::uint64_t index_mask = 0xFFFFFFFF;

/// A slot's tag of a key: hash bits that determine neither the shard nor the slot of all but the largest tables.
std::uint64_t tagged(std::uint64_t hash, std::size_t index) { return hash >> 28 << 32 | (index + 1); }
bool may_be(std::uint64_t slot, std::uint64_t hash) { return ((slot ^ hash >> 28 << 32) & ~index_mask) == 0; }

}  // namespace

std::size_t VoxelTable::size() const {
  std::size_t sum = 0;
  for (const Shard& shard : shards_) sum += shard.voxels.size();
  return sum;
}

std::uint64_t VoxelTable::key_of(const Eigen::Vector3d& position) const {
  const Eigen::Vector3d voxel = (position / side_m_).array().floor();
  // One by one: a maximum coefficient may skip NaN.
  if (!(voxel.array().abs() < static_cast<double>(half_range - 1)).all()) return 0;
  return packed(static_cast<std::int64_t>(voxel.x()), static_cast<std::int64_t>(voxel.y()),
                static_cast<std::int64_t>(voxel.z()));
}

Eigen::Vector3d VoxelTable::corner_of(std::uint64_t key) const {
  const auto coordinate = [&](int shift) {
    return static_cast<double>(static_cast<std::int64_t>(key >> shift & coordinate_mask) - half_range);
  };
  return side_m_ * Eigen::Vector3d(coordinate(0), coordinate(bits), coordinate(2 * bits));
}

const Voxel* VoxelTable::find(std::uint64_t key) const {
  const Shard& shard = shards_[static_cast<std::size_t>(shard_of(key))];
  if (shard.slots.empty()) return nullptr;
  const std::uint64_t hash = hash_of(key), mask = shard.slots.size() - 1;
  for (std::size_t slot = hash & mask; shard.slots[slot] != 0; slot = (slot + 1) & mask) {
    if (!may_be(shard.slots[slot], hash)) continue;
    const Voxel& voxel = shard.voxels[(shard.slots[slot] & index_mask) - 1];
    if (voxel.key == key) return &voxel;
  }
  return nullptr;
}

void VoxelTable::grow(Shard& shard) {
  shard.slots.assign(std::max<std::size_t>(256, shard.slots.size() * 2), 0);
  const std::size_t mask = shard.slots.size() - 1;
  for (std::size_t index = 0; index < shard.voxels.size(); ++index) {
    const std::uint64_t hash = hash_of(shard.voxels[index].key);
    std::size_t slot = hash & mask;
    while (shard.slots[slot] != 0) slot = (slot + 1) & mask;
    shard.slots[slot] = tagged(hash, index);
  }
}

Voxel& VoxelTable::voxel_at(std::uint64_t key) {
  Shard& shard = shards_[static_cast<std::size_t>(shard_of(key))];
  if (4 * (shard.voxels.size() + 1) > 3 * shard.slots.size()) grow(shard);
  const std::uint64_t hash = hash_of(key), mask = shard.slots.size() - 1;
  std::size_t slot = hash & mask;
  for (; shard.slots[slot] != 0; slot = (slot + 1) & mask) {
    if (!may_be(shard.slots[slot], hash)) continue;
    Voxel& voxel = shard.voxels[(shard.slots[slot] & index_mask) - 1];
    if (voxel.key == key) return voxel;
  }
  // Grows by less than a vector does by default: there may be millions.
  if (shard.voxels.size() == shard.voxels.capacity()) shard.voxels.reserve(shard.voxels.size() * 5 / 4 + 64);
  shard.slots[slot] = tagged(hash, shard.voxels.size());
  shard.voxels.emplace_back();
  shard.voxels.back().key = key;
  return shard.voxels.back();
}

void VoxelTable::add(std::uint64_t key, const WorldSample& sample, std::int32_t view) {
  Voxel& voxel = voxel_at(key);
  const Eigen::Vector3f position = (sample.point - corner_of(key)).cast<float>();
  const bool has_normal = !sample.normal.isZero();
  const Eigen::Vector3f normal = has_normal ? sample.normal : Eigen::Vector3f(-sample.ray.normalized());
  const float sigma_along = sample.sigma * std::abs(normal.dot(sample.ray));
  const float w = 1.0F / (sample.sigma * sample.sigma), d = normal.dot(position);
  voxel.weight += w;
  voxel.variance += w * w * sigma_along * sigma_along;
  voxel.along += w * d;
  voxel.along2 += w * d * d;
  voxel.position += w * position;
  if (has_normal) voxel.normal += w * normal;
  voxel.color += w * Eigen::Vector3f(sample.color[0], sample.color[1], sample.color[2]);
  ++voxel.count;
  if (voxel.last_view != view) ++voxel.views, voxel.last_view = view;
}

void VoxelTable::coarsen() {
  VoxelTable coarse(2.0 * side_m_);
  for (const Shard& shard : shards_) {
    for (const Voxel& fine : shard.voxels) {
      const Eigen::Vector3d corner = corner_of(fine.key);
      const std::uint64_t key = coarse.key_of(corner + Eigen::Vector3d::Constant(0.5 * side_m_));
      const Eigen::Vector3f shift = (corner - coarse.corner_of(key)).cast<float>();
      Voxel& voxel = coarse.voxel_at(key);
      const float d = fine.normal.isZero() ? 0.0F : fine.normal.normalized().dot(shift);
      voxel.along += fine.along + fine.weight * d;
      voxel.along2 += fine.along2 + 2.0F * d * fine.along + fine.weight * d * d;
      voxel.weight += fine.weight;
      voxel.variance += fine.variance;
      voxel.position += fine.position + fine.weight * shift;
      voxel.normal += fine.normal;
      voxel.color += fine.color;
      voxel.count += fine.count;
      voxel.views = std::max(voxel.views, fine.views);
      voxel.last_view = std::max(voxel.last_view, fine.last_view);
    }
  }
  *this = std::move(coarse);
}

}  // namespace rastro::detail
