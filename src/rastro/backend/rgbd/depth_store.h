// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "rastro/backend/rgbd/surface_check.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {

/// Surfaces of keyframes for verification: the most recently used ones are cached, the others are computed again from
/// their images. Thread-safe. `check` must outlive this.
class DepthStore {
 public:
  DepthStore(const SurfaceCheck& check, std::shared_ptr<const ImageStore> images)
      : check_(check), images_(std::move(images)) {}
  void add(std::int64_t keyframe, const DepthImage& depth);
  std::shared_ptr<const KeyframeSurface> depth(std::int64_t keyframe);

 private:
  struct Held {
    std::shared_ptr<const KeyframeSurface> grid;
    std::uint64_t last_use = 0;
  };
  void hold(std::int64_t keyframe, std::shared_ptr<const KeyframeSurface> grid);

  const SurfaceCheck& check_;
  std::shared_ptr<const ImageStore> images_;
  std::mutex mutex_;
  std::map<std::int64_t, Held> held_;
  std::uint64_t uses_ = 0;
};

}  // namespace rastro
