// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <mutex>
#include <optional>

#include "rastro/map/file/database.h"

namespace rastro {

/// The pictures of a map file, read when asked for. Who also writes to the database holds the mutex.
class FilePictures : public PictureStore {
 public:
  PackedPictures pictures(std::int64_t keyframe_id) const override;

  mutable std::mutex mutex;
  std::optional<Database> database;
};

}  // namespace rastro
