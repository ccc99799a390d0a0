// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/synthetic/scene.h"

namespace rastro::campus {

// Materials of the campus. Those with a `likeness` are painted alike wherever they have the same size and number, as
// parts of one make: corridors differ in wear, and in what hangs and stands in them.

/// Plaster above a darker, washable base with a handrail.
Material plaster();
/// Twelve tiles per bay, worn in the middle.
Material floor();
/// Panels of 0.6 m with two lamps per bay.
Material ceiling();
Material door(std::uint64_t likeness);
/// A window from inside: the sky, trees and houses outside.
Material view();
Material tread();

// What makes a place distinct: each one its own.
Material door_sign();
Material poster();
Material notice_board();
Material picture();

/// A bay of the building from outside, with two floors of windows.
Material facade(bool brick);
Material asphalt();
Material paving();
Material parking_line();

}  // namespace rastro::campus
