// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/base/error.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Keeps a trajectory as ground truth of a recording; a broken file costs the ground truth and gives a warning, not the
/// recording.
template <typename Read>
void read_ground_truth(SourceInfo& info, const std::filesystem::path& file, std::string frame, Read read) {
  try {
    info.ground_truth = read();
    info.ground_truth_file = file.string();
    info.ground_truth_frame = std::move(frame);
  } catch (const Error& error) {
    info.warnings.push_back(std::string("ground truth not used: ") + error.what());
  }
}

}  // namespace rastro
