// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/kitti/oxts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/kitti/kitti_images.h"
#include "rastro/dataset/kitti/kitti_raw.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t values_of_packet = 30;
constexpr double earth_radius_m = 6378137.0;
constexpr double degree = std::numbers::pi / 180.0;
constexpr double farthest_latitude_deg = 85.0, farthest_longitude_deg = 180.0;

SE3 projected(const OxtsPacket& packet, double scale) {
  const double east = scale * packet.longitude_deg * degree * earth_radius_m;
  const double north = scale * earth_radius_m * std::log(std::tan((90.0 + packet.latitude_deg) * degree / 2.0));
  const SO3 rotation = SO3::exp({0, 0, packet.yaw}) * SO3::exp({0, packet.pitch, 0}) * SO3::exp({packet.roll, 0, 0});
  return {rotation, {east, north, packet.altitude_m}};
}

std::vector<std::string> packet_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".txt") names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

OxtsPacket parse_oxts_packet(std::string_view text, std::string_view where) {
  const auto lines = content_lines(text);
  if (lines.size() != 1) throw Error(fmt::format("has {} lines, a packet has one", lines.size()), where, "");
  std::vector<double> values;
  for (const auto word : split_words(lines.front().text)) {
    const auto value = parse_finite(word);
    if (!value) throw Error(fmt::format("{} is not a finite number", in_quotes(word)), where, "");
    values.push_back(*value);
  }
  if (values.size() != values_of_packet)
    throw Error(fmt::format("has {} values, a packet has {}", values.size(), values_of_packet), where, "");
  const OxtsPacket packet{values[0], values[1], values[2], values[3], values[4], values[5]};
  if (std::abs(packet.latitude_deg) > farthest_latitude_deg || std::abs(packet.longitude_deg) > farthest_longitude_deg)
    throw Error(
        fmt::format("latitude {:g} and longitude {:g} cannot be projected", packet.latitude_deg, packet.longitude_deg),
        where, "");
  return packet;
}

std::vector<SE3> oxts_poses(std::span<const OxtsPacket> packets) {
  std::vector<SE3> poses;
  if (packets.empty()) return poses;
  const double scale = std::cos(packets.front().latitude_deg * degree);
  const SE3 first_from_map = projected(packets.front(), scale).inverse();
  poses.reserve(packets.size());
  for (const auto& packet : packets) poses.push_back(first_from_map * projected(packet, scale));
  return poses;
}

Trajectory read_oxts(const fs::path& folder) {
  const fs::path stamps_file = folder / "timestamps.txt";
  const auto stamps = parse_kitti_timestamps(read_text_file(stamps_file.string()), stamps_file.string());
  const auto names = packet_names(folder / "data");
  if (names.empty()) throw Error("has no packets (*.txt)", (folder / "data").string(), "");
  const auto rows = rows_of_images(names, stamps.size());
  std::vector<OxtsPacket> packets;
  std::vector<TimeNs> packet_stamps;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (rows[k] < 0) continue;
    const std::string file = (folder / "data" / names[k]).string();
    packets.push_back(parse_oxts_packet(read_text_file(file), file));
    packet_stamps.push_back(stamps[static_cast<std::size_t>(rows[k])]);
  }
  if (!std::is_sorted(packet_stamps.begin(), packet_stamps.end()))
    throw Error("the stamps go backward", stamps_file.string(), "");
  const auto poses = oxts_poses(packets);
  Trajectory trajectory;
  for (std::size_t k = 0; k < poses.size(); ++k) trajectory.push_back({packet_stamps[k], poses[k]});
  return trajectory;
}

std::optional<SE3> oxts_from_first_camera(const fs::path& folder, const fs::path& cam_to_cam, bool rectified) {
  const fs::path imu = folder / "calib_imu_to_velo.txt", velodyne = folder / "calib_velo_to_cam.txt";
  if (!is_file(imu) || !is_file(velodyne)) return std::nullopt;
  const SE3 camera_from_body = read_kitti_transform(velodyne.string()) * read_kitti_transform(imu.string());
  if (!rectified) return camera_from_body.inverse();
  const auto rectified_from_camera = read_kitti_rectification(cam_to_cam.string());
  if (!rectified_from_camera) return std::nullopt;
  return (SE3(*rectified_from_camera, Eigen::Vector3d::Zero()) * camera_from_body).inverse();
}

}  // namespace rastro
