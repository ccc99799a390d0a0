// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// Where the GPS/IMU unit of KITTI raw was: the first 6 of the 30 values of a packet in oxts/data.
struct OxtsPacket {
  double latitude_deg = 0.0, longitude_deg = 0.0;
  double altitude_m = 0.0;
  double roll = 0.0, pitch = 0.0, yaw = 0.0;  ///< Radians; x forward, y left, z up; yaw 0 is east, to the left.
};

/// Error naming `where` for anything but 30 finite numbers, and for a
/// position that is not on the map of Mercator's projection (85 degrees).
OxtsPacket parse_oxts_packet(std::string_view text, std::string_view where);

/// The poses in the frame of the first packet, by Mercator's projection at its latitude, as the raw data's own tools
/// make them (Geiger et al. 2013).
std::vector<SE3> oxts_poses(std::span<const OxtsPacket> packets);

/// Reads `folder`/timestamps.txt and `folder`/data/*.txt. Packets belong to the stamp of the number in their name.
/// Errors for broken text and for stamps that go backward.
Trajectory read_oxts(const std::filesystem::path& folder);

/// body_from_camera of the rectified camera 0 from calib_imu_to_velo.txt and calib_velo_to_cam.txt in `folder` and
/// R_rect_00 of `cam_to_cam`; of the camera as it is where not `rectified`. nullopt where a file is not there.
std::optional<SE3> oxts_from_first_camera(const std::filesystem::path& folder, const std::filesystem::path& cam_to_cam,
                                          bool rectified);

}  // namespace rastro
