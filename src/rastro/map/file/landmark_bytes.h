// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/map/file/bytes.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// A landmark without a filter's estimate of it, as in map files of all versions.
Landmark get_landmark(ByteReader& bytes, std::int64_t id);

}  // namespace rastro
