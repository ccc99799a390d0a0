// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/cli/export_input.h"
#include "rastro/export/mcap/mcap_run.h"
#include "rastro/viewer/run_record.h"
#include "rastro/viewer/scene.h"

namespace rastro::cli {

/// What an MCAP file shows of an input, from what the browser shows of it (view_scene_of) and what the run noted of its
/// frames (notes_of_run): poses in full precision and stamps in nanoseconds. `submap` is that of the scene. Images of
/// the keyframes are those in the map, if any; it must outlive the result.
McapRun mcap_run_of(const ExportInput& input, const RunRecord& record, const ViewScene& scene, int submap);

/// How grave a state or event is.
McapRun::Level mcap_level_of(const std::string& kind);

}  // namespace rastro::cli
