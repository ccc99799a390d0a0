// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro {

struct RecoveredMap {
  std::shared_ptr<const Map> map;  ///< Images are in memory.
  bool finished = false;           ///< Whether the file states how much it should contain.
  std::vector<std::string> lost;   ///< One clause each, such as "2 of 6 keyframes".
};

/// Recovers what is left of a map file that load_map() refuses: every row with a valid checksum, wherever in the file
/// it is found; the file's own index of its rows is not trusted. Error where not even the head is left.
RecoveredMap recover_map(const std::filesystem::path& file);

}  // namespace rastro
