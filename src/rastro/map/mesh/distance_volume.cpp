// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/mesh/distance_volume.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "rastro/base/error.h"
#include "rastro/map/images/map_views.h"

namespace rastro::detail {
namespace {

constexpr int farthest_block = 1 << 20;
constexpr int samples_between = 4;  ///< Blocks are found from every n-th sample, since pixels are dense.

bool precedes(const BlockIndex& a, const BlockIndex& b) {
  return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
}

}  // namespace

/// One keyframe's samples by pixel.
struct DistanceVolume::View {
  const Camera& camera;
  int width, height;
  SE3 camera_from_world;
  const std::vector<SurfaceSample>& samples;
  std::vector<std::int32_t> of_pixel;  ///< Index into samples; -1: none.

  const SurfaceSample* seen_from(const Eigen::Vector3d& in_camera) const {
    const auto pixel = camera.project(in_camera);
    if (!pixel) return nullptr;
    const double x = std::round(pixel->x()), y = std::round(pixel->y());
    if (!(x >= 0.0 && y >= 0.0 && x < width && y < height)) return nullptr;
    const std::int32_t index =
        of_pixel[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    return index < 0 ? nullptr : &samples[static_cast<std::size_t>(index)];
  }
};

DistanceVolume::DistanceVolume(const MeshOptions& options)
    : voxel_m_(options.voxel_m),
      truncation_m_(options.truncation_m > 0.0 ? options.truncation_m : 4.0 * options.voxel_m),
      max_blocks_(options.max_blocks) {}

std::uint64_t DistanceVolume::key_of(const BlockIndex& index) {
  const auto biased = [](int value) { return static_cast<std::uint64_t>(value + farthest_block); };
  return biased(index.z()) << 42 | biased(index.y()) << 21 | biased(index.x());
}

int DistanceVolume::block_at(const BlockIndex& index) const {
  const auto found = index_.find(key_of(index));
  return found == index_.end() ? -1 : found->second;
}

std::vector<int> DistanceVolume::touch(const std::vector<SurfaceSample>& samples, const SE3& world_from_camera) {
  const double block_m = block_side * voxel_m_;
  const int steps = static_cast<int>(std::ceil(truncation_m_ / (0.5 * block_m)));
  std::vector<int> touched;
  for (std::size_t k = 0; k < samples.size(); k += samples_between) {
    const Eigen::Vector3d point = samples[k].point_in_camera.cast<double>();
    for (int step = -steps; step <= steps; ++step) {
      const Eigen::Vector3d position = point + point.normalized() * (truncation_m_ * step / steps);
      const Eigen::Vector3d in_blocks = (world_from_camera * position / block_m).array().floor();
      if (!(in_blocks.cwiseAbs().maxCoeff() < farthest_block - 2)) continue;
      const BlockIndex block = in_blocks.cast<int>();
      const auto [found, is_new] = index_.try_emplace(key_of(block), static_cast<int>(blocks_.size()));
      if (is_new) {
        blocks_.push_back(std::make_unique<DistanceBlock>());
        blocks_.back()->index = block;
      }
      if (touched.empty() || touched.back() != found->second) touched.push_back(found->second);
    }
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  if (blocks_.size() > max_blocks_)
    throw Error(fmt::format("the map is too large for a mesh with voxels of {:g} m", voxel_m_), "--voxel",
                "give larger ones");
  return touched;
}

void DistanceVolume::update(DistanceBlock& block, const View& view) const {
  for (int cell = 0; cell < block_cells; ++cell) {
    const Eigen::Vector3i inside(cell % block_side, cell / block_side % block_side, cell / (block_side * block_side));
    const Eigen::Vector3d center =
        voxel_m_ * ((block_side * block.index + inside).cast<double>() + Eigen::Vector3d::Constant(0.5));
    const Eigen::Vector3d in_camera = view.camera_from_world * center;
    const SurfaceSample* sample = view.seen_from(in_camera);
    if (sample == nullptr) continue;
    // Perpendicular to the surface where its normal is known, else along the ray.
    const Eigen::Vector3d to_surface = sample->point_in_camera.cast<double>() - in_camera;
    const Eigen::Vector3d normal = sample->normal_in_camera.cast<double>();
    const double ahead = to_surface.z() * in_camera.norm() / in_camera.z();
    const double distance = normal.isZero() ? ahead : -normal.dot(to_surface);
    if (ahead < -truncation_m_ || distance < -truncation_m_) continue;
    DistanceVoxel& voxel = block.voxels[static_cast<std::size_t>(cell)];
    const float w = 1.0F / (sample->sigma * sample->sigma), share = w / (voxel.weight + w);
    voxel.distance += share * (static_cast<float>(std::min(distance, truncation_m_)) - voxel.distance);
    for (std::size_t k = 0; k < 3; ++k) {
      const float mixed = voxel.color[k] + share * (static_cast<float>(sample->color[k]) - voxel.color[k]);
      voxel.color[k] = static_cast<std::uint8_t>(std::clamp(std::lround(mixed), 0L, 255L));
    }
    voxel.weight += w;
    if (voxel.views < 255) ++voxel.views;
  }
}

void DistanceVolume::add(const std::vector<SurfaceSample>& samples, const Camera& camera, int width, int height,
                         const SE3& world_from_camera, TaskPool* pool) {
  View view{camera, width, height, world_from_camera.inverse(), samples, {}};
  view.of_pixel.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), -1);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto pixel = camera.project(samples[k].point_in_camera.cast<double>());
    if (!pixel) continue;
    const int x = std::clamp(static_cast<int>(std::lround(pixel->x())), 0, width - 1);
    const int y = std::clamp(static_cast<int>(std::lround(pixel->y())), 0, height - 1);
    view.of_pixel[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
        static_cast<std::int32_t>(k);
  }
  const std::vector<int> touched = touch(samples, world_from_camera);
  for_each_index(pool, touched.size(),
                 [&](std::size_t k) { update(*blocks_[static_cast<std::size_t>(touched[k])], view); });
}

void DistanceVolume::sort() {
  std::sort(blocks_.begin(), blocks_.end(), [](const auto& a, const auto& b) { return precedes(a->index, b->index); });
  for (std::size_t k = 0; k < blocks_.size(); ++k) index_[key_of(blocks_[k]->index)] = static_cast<int>(k);
}

}  // namespace rastro::detail
