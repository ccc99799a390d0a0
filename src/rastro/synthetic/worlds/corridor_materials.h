// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/synthetic/scene.h"

namespace rastro::corridor {

// Materials of an office floor. `tone` is the mean intensity of the bare material, 0..255.

/// With notices, sockets and scuffs on it, few where `bare`.
Material wall(bool bare);
Material carpet();
Material ceiling();
Material wood(float tone);
Material metal(float tone);
Material cloth(float tone);
Material skin();
Material leaves();

}  // namespace rastro::corridor
