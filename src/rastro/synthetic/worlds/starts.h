// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

/// Kinds of scenes in which monocular map initialization is hard.
enum class StartKind : std::uint8_t {
  planar,          ///< One wall fills the view.
  far,             ///< Nothing nearer than 18 m, at walking speed.
  near,            ///< Objects at 0.5 to 1.5 m, at 0.3 m/s.
  rotation_first,  ///< start_rotation_frames of rotation in place; then it moves.
  low_texture,     ///< A bare room with a few signs.
};
constexpr StartKind start_kinds[] = {StartKind::planar, StartKind::far, StartKind::near, StartKind::rotation_first,
                                     StartKind::low_texture};
constexpr int start_variations = 4;  ///< Of each kind: different scenes and trajectories.
constexpr std::int64_t start_frames = 60, start_rotation_frames = 24;

const char* name_of(StartKind kind);  ///< "planar", "far", ...

/// A short recording for tests of map initialization: 320x240, f = 230, 20 Hz; the camera is the body. `variation` is 0
/// to start_variations - 1.
World make_start(StartKind kind, int variation);

}  // namespace rastro
