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
  bool finished = false;           ///< The file said how much it should hold.
  std::vector<std::string> lost;   ///< One clause each, such as "2 of 6 keyframes".
};

/// What can be saved of a map file that load_map() refuses: every row whose checksum holds, wherever in the file it is
/// found; the file's own index of its rows is not relied on. Error where not even the head is left.
RecoveredMap recover_map(const std::filesystem::path& file);

}  // namespace rastro
