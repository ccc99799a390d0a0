// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>

#include "rastro/base/task_pool.h"
#include "rastro/map/graph/map.h"

namespace rastro {

struct WordImageCounts {
  std::size_t locations = 0;      ///< One picture each.
  std::size_t loop_closures = 0;  ///< Locations with a match.
};

/// One JPEG per location of a map with signatures, ID.jpg by the id of its keyframe: its image with its visual words in
/// the colors of their kinds (WordKind) on the left, the earlier location that it closed a loop with on the right (the
/// shared words pink, the others red: they are in the vocabulary by now), the counts of words and the constraint below.
/// Features without a word are omitted; an image that the map does not have is gray. The bytes do not depend on the
/// pool. Error where the map has no locations, or the folder or a file cannot be written.
WordImageCounts write_word_images(const Map& map, const std::filesystem::path& folder, TaskPool& pool,
                                  const std::function<void(std::size_t done, std::size_t all)>& progress = {});

}  // namespace rastro
