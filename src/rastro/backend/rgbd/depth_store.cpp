// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/depth_store.h"

#include <fmt/format.h>

#include "rastro/map/images/pack_images.h"

namespace rastro {

void DepthStore::add(std::int64_t keyframe, const DepthImage& depth) {
  recent_.add(keyframe, check_.surface_of(depth));
}

std::shared_ptr<const KeyframeSurface> DepthStore::depth(std::int64_t keyframe) {
  if (auto recent = recent_.find(keyframe)) return recent;
  const DepthImage depth = unpack_depth(images_->read(keyframe), fmt::format("keyframe {}", keyframe));
  return recent_.add(keyframe, check_.surface_of_unpacked(depth));
}

}  // namespace rastro
