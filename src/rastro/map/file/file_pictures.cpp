// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/file_pictures.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"

namespace rastro {

PackedPictures FilePictures::pictures(std::int64_t keyframe_id) const {
  const std::lock_guard lock(mutex);
  RASTRO_CHECK(database.has_value(), "the map file of these pictures is open");
  RowReader rows(*database, MapTable::pictures, keyframe_id);
  if (!rows.next() || rows.id() != keyframe_id)
    refuse_damaged(database->file(), fmt::format("lacks the pictures of keyframe {}", keyframe_id));
  return read_pictures(rows.body(), rows.where());
}

}  // namespace rastro
