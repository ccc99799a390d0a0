// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>

#include "rastro/map/images/image_layer.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// The color image (the gray one where there is none) and the depth of a frame, packed. The same bytes for the same
/// pixels. Depth beyond 13.1 m does not fit 16 bits and is left out.
PackedImages pack_images(const Frame& frame);
/// Without packed depth, the depth is 0 everywhere. Error (naming `where`) for bytes that are not such images, or
/// images of different sizes.
UnpackedImages unpack_images(const PackedImages& images, const std::string& where);

/// Images in memory. Thread-safe.
class MemoryImages : public ImageStore {
 public:
  void add(std::int64_t keyframe_id, PackedImages images);
  PackedImages images(std::int64_t keyframe_id) const override;

 private:
  mutable std::mutex mutex_;
  std::map<std::int64_t, PackedImages> images_;
};

}  // namespace rastro
