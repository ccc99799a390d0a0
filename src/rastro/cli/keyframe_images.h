// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rastro/camera/stereo_rectification.h"
#include "rastro/cli/recording_of_run.h"
#include "rastro/map/graph/map.h"
#include "rastro/sensor/source.h"

namespace rastro::cli {

/// How the left images of a recording become those of the map's camera; nothing where they are the same. Error where
/// the calibration of the recording makes other ones.
std::optional<StereoRectification> rectification_of(const Map& map, const SourceInfo& info);

/// Writes the recorded image of each keyframe of a submap (-1: of all) into `folder`: a copy of its file under its own
/// name (spaces become '_'; `session1_` before it for the second recording, ...), or a JPEG where the recording has no
/// image files or the map's camera is that of a rectified pair. Returns the names; a keyframe that the recording has no
/// frame of gets none, with a warning. Error where a recording cannot be read, or its camera is not that of the map.
std::map<KeyframeId, std::string> write_keyframe_images(const Map& map, int submap,
                                                        const std::vector<MapRecording>& recordings,
                                                        const std::filesystem::path& folder);

}  // namespace rastro::cli
