// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/synthetic/scene.h"

namespace rastro::hall {

// Materials of the machine hall. `tone` is the mean intensity of the bare material, 0..255.

Material concrete_floor();
Material brick_wall();
Material ceiling_sheet();
/// `panel_m`: size of the smallest panels.
Material machine(float tone, double texels_per_meter = 170.0, double panel_m = 0.40);
Material cabinet(float tone);
Material tank(float tone);
Material pipe(float tone);
Material steel_beam(float tone, double texels_per_meter = 110.0);
Material concrete_pillar();
Material wooden_crate();
Material cardboard();
Material drum(float tone);
/// Of a drum, for its ends.
Material lid(float tone);
Material window();
Material gate();
Material sign(bool hazard);
Material lamp();

}  // namespace rastro::hall
