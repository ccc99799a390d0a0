// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "rastro/math/se3.h"
#include "rastro/synthetic/path.h"
#include "rastro/synthetic/scene.h"

namespace rastro::hall {

/// World frame: x along the hall, y to the left, z up, the floor at z = 0, the drone starts above the origin.
std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail = 1.0);

/// The drone's flight; see make_hall().
CameraPath flight();

constexpr double rate_hz = 20.0;

}  // namespace rastro::hall
