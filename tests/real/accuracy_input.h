// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "accuracy_row.h"
#include "rastro/evaluate/relations.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// The frames of one row with their ground truth.
struct AccuracyInput {
  std::shared_ptr<const void> world;  ///< That the source renders; null for recordings. Declared first: it goes last.
  std::unique_ptr<Source> source;
  Trajectory ground_truth;  ///< Of the camera or of the robot, as the method's poses are.
  std::vector<Relation> relations;
};

/// Folder of recorded data: RASTRO_DATA, or ../shared/data beside the checkout.
std::filesystem::path recorded_data();

/// What the row's recording is read from; empty for a generated one.
std::filesystem::path recorded_file(const AccuracyRow& row);

/// Error where it cannot be read or has no ground truth.
AccuracyInput open_input(const AccuracyRow& row);

}  // namespace rastro
