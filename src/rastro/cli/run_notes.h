// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/cli/export_input.h"
#include "rastro/viewer/run_record.h"

namespace rastro::cli {

/// What the folder of a run says of its frames: stats.csv, events.jsonl, trajectory_online.txt, covariance_online.txt,
/// each where it is there, and the ground truth of its recording, aligned, where that can be read. Of a file alone: its
/// poses. Error, with the line, for a file that is damaged.
RunRecord notes_of_run(const ExportInput& input);

}  // namespace rastro::cli
