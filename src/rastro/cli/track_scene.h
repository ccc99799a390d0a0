// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/viewer/scene.h"

namespace rastro::cli {

/// Whether it is the folder of a run of `rastro track`.
bool is_track_run(const std::string& path);

/// What `rastro view` shows of such a run: its frames on the timeline, good or weak, the ground truth of the recording
/// where it has one, and on request each image with its features by state, their ids, and where they were in the frames
/// before. Images come from the recording; where that has gone, features are shown without. Error for tracks that
/// cannot be read.
NamedScene track_scene(const std::string& path);

}  // namespace rastro::cli
