// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/map/file/bytes.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// A landmark without what a filter knows of it, as map files of all versions have it.
Landmark get_landmark(ByteReader& bytes, std::int64_t id);

}  // namespace rastro
