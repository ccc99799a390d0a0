// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>

#include "rastro/map/images/image_layer.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// The colour picture (the grey one where there is none) and the depth of a frame, packed. The same bytes for the same
/// pixels. Depth beyond 13.1 m does not fit 16 bits and is left out.
PackedPictures pack_pictures(const Frame& frame);
/// Without packed depth there is none anywhere. Error (naming `where`) for bytes that are not such pictures, or
/// pictures of two sizes.
UnpackedPictures unpack_pictures(const PackedPictures& pictures, const std::string& where);

/// Pictures in memory. Several threads may ask and add.
class MemoryPictures : public PictureStore {
 public:
  void add(std::int64_t keyframe_id, PackedPictures pictures);
  PackedPictures pictures(std::int64_t keyframe_id) const override;

 private:
  mutable std::mutex mutex_;
  std::map<std::int64_t, PackedPictures> pictures_;
};

}  // namespace rastro
