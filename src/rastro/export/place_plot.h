// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/map/graph/place_belief.h"

namespace rastro {

/// Draws what a method believed about places over the keyframes of a run, into a .svg or .png. Above the probabilities
/// of a new place and of the most likely known location, with the threshold; below which location that was, light where
/// it stayed below the threshold. Keyframes that were matched with an earlier place are green, with that place;
/// locations that were compared in vain are red, above only the most likely one. The axes are ids of keyframes. Error
/// where there is nothing to plot, the name ends otherwise, or it cannot be written.
void write_place_plot(const std::vector<PlaceBelief>& places, const std::string& file);

}  // namespace rastro
