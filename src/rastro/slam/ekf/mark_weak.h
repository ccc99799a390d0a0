// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "rastro/slam/slam.h"

namespace rastro {

/// The first reason stays: later ones often follow from it.
inline void mark_weak(SlamUpdate& update, SlamReason reason, std::string detail) {
  update.state = SlamState::weak;
  if (update.reason != SlamReason::none && update.reason != SlamReason::first_frame) return;
  update.reason = reason;
  update.detail = std::move(detail);
}

}  // namespace rastro
