// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "rastro/synthetic/named_length.h"
#include "rastro/synthetic/scene.h"
#include "rastro/synthetic/worlds/room_walk.h"

namespace rastro::room {

/// A room and the camera's trajectory through it.
struct Room {
  std::unique_ptr<Scene> scene = std::make_unique<Scene>();
  std::vector<NamedLength> lengths;
  Walk walk;
};
Room build_bedroom(std::uint64_t seed);
Room build_study(std::uint64_t seed);

}  // namespace rastro::room
