// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/depth_store.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/map/images/pack_images.h"

namespace rastro {

void DepthStore::add(std::int64_t keyframe, const DepthImage& depth) {
  auto grid = std::make_shared<const KeyframeSurface>(check_.surface_of(depth));
  const std::lock_guard lock(mutex_);
  hold(keyframe, std::move(grid));
}

std::shared_ptr<const KeyframeSurface> DepthStore::depth(std::int64_t keyframe) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = held_.find(keyframe); found != held_.end()) {
      found->second.last_use = ++uses_;
      return found->second.grid;
    }
  }
  const UnpackedImages images = unpack_images(images_->read(keyframe), fmt::format("keyframe {}", keyframe));
  auto grid = std::make_shared<const KeyframeSurface>(check_.surface_of(images.depth));
  const std::lock_guard lock(mutex_);
  hold(keyframe, grid);
  return grid;
}

void DepthStore::hold(std::int64_t keyframe, std::shared_ptr<const KeyframeSurface> grid) {
  constexpr std::size_t most = 64;
  held_[keyframe] = {std::move(grid), ++uses_};
  if (held_.size() <= most) return;
  held_.erase(std::min_element(held_.begin(), held_.end(),
                               [](const auto& a, const auto& b) { return a.second.last_use < b.second.last_use; }));
}

}  // namespace rastro
