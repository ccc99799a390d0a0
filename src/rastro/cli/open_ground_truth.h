// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/evaluate/surface_ground_truth.h"

namespace rastro::cli {

/// Surface ground truth of a generated recording, with the size of its images.
struct OpenedGroundTruth {
  std::unique_ptr<SurfaceGroundTruth> ground_truth;
  int image_width = 0;
  int image_height = 0;
  std::vector<TimeNs> stamps;  ///< Of its frames.
};

/// Reads the ground truth in a folder written by `rastro simulate`. Error where there is none.
OpenedGroundTruth open_ground_truth(const std::string& data_folder);

}  // namespace rastro::cli
