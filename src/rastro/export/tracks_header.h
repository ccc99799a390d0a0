// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/camera/camera.h"

namespace rastro {

/// What stands at the head of an exported track file. Nothing here may differ between two runs of one command:
/// no times, no paths.
struct TracksHeader {
  std::vector<std::pair<std::string, std::string>> options;  ///< Name and value in use.
  std::optional<Camera> camera;                              ///< nullopt: the rays are NaN.
};

}  // namespace rastro
