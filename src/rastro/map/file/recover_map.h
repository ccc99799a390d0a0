// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "rastro/map/keyframe/rgbd_map.h"
#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

struct RecoveredMap {
  std::shared_ptr<const RgbdMap> map;               ///< Keyframes are numbered anew; pictures are in memory.
  std::shared_ptr<const LandmarkMap> landmark_map;  ///< One of both, by the kind of the file. Keeps its numbers.
  bool finished = false;                            ///< The file said how much it should hold.
  std::vector<std::string> lost;                    ///< One clause each, such as "2 of 6 keyframes (3, 4)".
};

/// What can be saved of a map file that load_map() refuses: every row whose checksum holds, wherever in the file it is
/// found; the file's own index of its rows is not relied on. Error where not even the camera is left.
RecoveredMap recover_map(const std::filesystem::path& file);

}  // namespace rastro
