// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/evaluate/surface_truth.h"

namespace rastro::cli {

/// Surface truth of a generated sequence, with the size of its images.
struct OpenedTruth {
  std::unique_ptr<SurfaceTruth> truth;
  int image_width = 0;
  int image_height = 0;
};

/// Reads the truth in a folder written by `rastro simulate`. Error where there is none.
OpenedTruth open_truth(const std::string& data_folder);

}  // namespace rastro::cli
