// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace rastro::campus {

// World frame: x east, y north, z up, the ground at z = 0; meters. Four corridors per floor form a ring around a
// courtyard: their center lines are x = 0, x = ring_x, y = 0 and y = ring_y on both floors.
constexpr double ring_x = 60.0, ring_y = 40.0;
constexpr double half_corridor = 1.5, ceiling_m = 2.8, storey_m = 3.6;
constexpr double bay_m = 6.0;  ///< Doors, lamps and windows repeat at this distance.

// Outside of the building, and the courtyard in it.
constexpr double outer_west = -6.0, outer_east = 76.05, outer_south = -6.0, outer_north = 46.0;
constexpr double court_west = 6.0, court_east = 54.0, court_south = 6.0, court_north = 34.0;
constexpr double roof_m = 7.6, top_m = storey_m + ceiling_m;

// Stairs, 20 steps each: up in the south from stairs_up_x on, down in the north from stairs_down_x on, both eastwards.
constexpr double stairs_up_x = 64.0, stairs_down_x = 64.8, step_m = 0.36, rise_m = 0.18;
constexpr int steps = 20;
constexpr double stairs_m = steps * step_m;

}  // namespace rastro::campus
