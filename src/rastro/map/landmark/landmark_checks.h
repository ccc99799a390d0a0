// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// What in a map contradicts itself, as a clause such as "has a landmark seen by a keyframe that is not there"; empty
/// where everything fits: ids ascend, every reference leads somewhere, the spanning tree is one.
std::string contradiction_in(const LandmarkMap& map);

}  // namespace rastro
