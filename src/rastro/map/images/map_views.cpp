// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/map_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/images/pack_images.h"

namespace rastro::detail {

void for_each_index(TaskPool* pool, std::size_t count, const std::function<void(std::size_t)>& body) {
  const auto over = [&](int begin, int end) {
    for (int k = begin; k < end; ++k) body(static_cast<std::size_t>(k));
  };
  if (pool == nullptr) return over(0, static_cast<int>(count));
  pool->for_chunks(0, static_cast<int>(count), 1, over);
}

std::vector<std::size_t> keyframes_of(const Map& map, int submap) {
  const auto images = map.layer<ImageLayer>();
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    const bool wanted = submap < 0 || keyframe.submap == submap;
    const bool shown = !images || std::binary_search(images->keyframes.begin(), images->keyframes.end(), keyframe.id);
    if (wanted && shown && keyframe.world_from_camera.matrix().allFinite()) chosen.push_back(k);
  }
  return chosen;
}

SurfaceOptions surface_options(const Map& map, int stride, double min_depth_m, double max_depth_m) {
  SurfaceOptions options;
  options.stride = stride;
  options.min_depth_m = min_depth_m;
  options.max_depth_m = max_depth_m;
  if (map.cameras.empty()) return options;
  options.depth_sigma_m = map.cameras.front().depth_noise.sigma_m;
  options.depth_sigma_per_m2 = map.cameras.front().depth_noise.sigma_per_m2;
  return options;
}

MapViews::MapViews(const Map& map, std::vector<std::size_t> keyframes, TaskPool* pool, std::size_t at_once)
    : map_(map), images_(images_of(map)), keyframes_(std::move(keyframes)), pool_(pool), at_once_(at_once) {
  if (!keyframes_.empty() && (!images_ || map.cameras.empty()))
    throw Error("has no depth images", "the map", "give a map of a depth camera");
}

UnpackedImages MapViews::packed_images_of(std::size_t keyframe) const {
  const std::int64_t id = map_.keyframes[keyframe].id;
  return unpack_images(images_->read(id), fmt::format("keyframe {}", id));
}

void MapViews::walk(const Prepare& prepare, const Merge& merge,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  for (std::size_t first = 0; first < keyframes_.size(); first += at_once_) {
    if (rays_.width() == 0) {
      const DepthImage depth = packed_images_of(keyframes_.front()).depth;
      rays_ = RayTable(map_.cameras.front().intrinsics, depth.width(), depth.height());
    }
    const std::size_t count = std::min(at_once_, keyframes_.size() - first);
    for_each_index(pool_, count, [&](std::size_t slot) {
      const std::size_t keyframe = keyframes_[first + slot];
      const UnpackedImages images = packed_images_of(keyframe);
      if (images.depth.width() != rays_.width() || images.depth.height() != rays_.height())
        throw Error("its images are of another size than the first ones", fmt::format("keyframe {}", keyframe),
                    "'rastro recover' saves what can be read");
      prepare(slot, keyframe, images, rays_);
    });
    merge(first, count);
    if (progress) progress(first + count, keyframes_.size());
  }
}

}  // namespace rastro::detail
