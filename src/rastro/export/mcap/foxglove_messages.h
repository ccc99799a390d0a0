// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <string>

#include "rastro/export/mcap/mcap_run.h"

// Messages of Foxglove's schemas as Protobuf's bytes. `time` is their time stamp.

namespace rastro::detail {

/// The names of the frames of reference. The upright one has the same origin as the world, z up.
constexpr const char *upright_frame = "upright", *world_frame = "world";
const char* moving_frame(const McapRun& run);  ///< "camera" or "body".

std::string pose_message(TimeNs time, const SE3& pose);
std::string poses_message(TimeNs time, const Trajectory& trajectory);
/// Of the moving frame in the world.
std::string transform_message(TimeNs time, const McapRun& run, const SE3& world_from_body);
/// Of the world in the upright frame.
std::string upright_message(TimeNs time, const Eigen::Vector3d& up);
std::string points_message(TimeNs time, const McapRun::Points& points);
std::string grid_message(TimeNs time, const McapRun::Grid& grid);
std::string image_message(TimeNs time, const McapRun& run, const std::string& jpeg);
std::string calibration_message(TimeNs time, const McapRun& run);
std::string log_message(const McapRun::Note& note);

// Scenes: one entity per keyframe, kind of edges, kind of ellipsoids.
std::string keyframes_message(TimeNs time, const McapRun& run);
std::string graph_message(TimeNs time, const McapRun& run);
std::string covariances_message(TimeNs time, const McapRun& run);
std::string path_message(TimeNs time, const std::string& name, const std::vector<Eigen::Vector3d>& path);

/// The FileDescriptorSet with all messages, of package foxglove.
std::string foxglove_schemas();

}  // namespace rastro::detail
