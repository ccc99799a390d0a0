// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro::cli {

/// The recording that a run was made from, as its about.json says; nothing where there is none or it is gone.
struct RecordingOfRun {
  std::string path;    ///< As it can be opened from here; empty: unknown.
  std::string camera;  ///< Of the recording; empty: its usual one.
};
RecordingOfRun recording_of_run(const std::filesystem::path& run_or_map);

/// A recording and the keyframes of a map that are of it.
struct MapRecording {
  RecordingOfRun recording;  ///< Its path is empty where it is gone.
  std::string named;         ///< As the map names it, for messages.
  std::set<KeyframeId> keyframes;
};

/// The recordings of all sessions of a map, in their order; of a map of one session, that of its run. `given` (as with
/// --images), if not empty, stands for all of them. Each has keyframes; several sessions may be of one recording.
std::vector<MapRecording> recordings_of_map(const Map& map, const std::filesystem::path& run_or_map,
                                            const std::string& given);

/// The last session whose recording the reference is, or lies in the folder of; nullopt where there is none. Several
/// sessions of one recording have one clock, so that any of them does.
std::optional<std::size_t> session_of_reference(const Map& map, const std::filesystem::path& run_or_map,
                                                const std::filesystem::path& reference);

/// Whether any is there.
bool any_found(const std::vector<MapRecording>& recordings);

}  // namespace rastro::cli
