// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/math/se2.h"

namespace rastro {

/// To the last bit, as of a message that is repeated.
inline bool same_pose(const SE2& a, const SE2& b) {
  return a.translation() == b.translation() && a.rotation().angle() == b.rotation().angle();
}

}  // namespace rastro
