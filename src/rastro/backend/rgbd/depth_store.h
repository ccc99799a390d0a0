// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "rastro/backend/rgbd/recent_items.h"
#include "rastro/backend/rgbd/surface_check.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {

/// Surfaces of keyframes for verification: the most recently used ones are cached, the others are computed again from
/// their images. Thread-safe. `check` must outlive this.
class DepthStore {
 public:
  /// `most`: that are cached.
  DepthStore(const SurfaceCheck& check, std::shared_ptr<const ImageStore> images, std::size_t most = usual_most)
      : check_(check), images_(std::move(images)), recent_(most) {}
  static constexpr std::size_t usual_most = 64;
  void add(std::int64_t keyframe, const DepthImage& depth);
  std::shared_ptr<const KeyframeSurface> depth(std::int64_t keyframe);
  void clear() { recent_.clear(); }  ///< What is cached.

 private:
  const SurfaceCheck& check_;
  std::shared_ptr<const ImageStore> images_;
  RecentItems<KeyframeSurface> recent_;
};

}  // namespace rastro
