// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rastro/synthetic/world.h"

namespace rastro::cli {

struct WorldFlags {
  std::uint64_t seed = 1;
  int threads = 0;
  bool distortion = false;
};

/// A world of `rastro simulate`.
struct SimulatedWorld {
  const char* name;
  const char* text;  ///< What it is, for the list of worlds.
  const char* default_format;
  std::int64_t default_frames;  ///< At its full rate; 0: the whole drive.
  bool has_stereo;
  bool has_closures;  ///< Its recordings come with closures.yaml.
  World (*make)(const WorldFlags&);
};

const std::vector<SimulatedWorld>& simulated_worlds();

/// Throws Error for an unknown name.
const SimulatedWorld& simulated_world(const std::string& name);

/// All with their texts, as `rastro simulate` prints them.
std::string simulated_worlds_text();

}  // namespace rastro::cli
