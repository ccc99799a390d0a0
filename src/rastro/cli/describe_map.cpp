// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/describe_map.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

namespace rastro::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 4> edge_kinds = {"way", "near", "loop", "join"};

struct MapFigures {
  std::set<int> submaps;
  std::array<std::int64_t, edge_kinds.size()> edges{};
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();  ///< Of the places of the cameras.
  std::size_t features = 0;
  double seconds = 0.0;
};

MapFigures figures_of(const RgbdMap& map) {
  MapFigures figures;
  Eigen::AlignedBox3d box;
  for (const KeyframePose& pose : map.poses) {
    figures.submaps.insert(pose.submap);
    if (pose.submap == 0) box.extend(pose.world_from_camera.translation());
  }
  if (!box.isEmpty()) figures.extent = box.sizes();
  for (const PoseEdge& edge : map.edges) ++figures.edges[static_cast<std::size_t>(edge.kind)];
  for (const auto& keyframe : map.keyframes) figures.features += keyframe->features.size();
  if (!map.trajectory.empty()) figures.seconds = to_seconds(map.trajectory.back().stamp - map.trajectory.front().stamp);
  return figures;
}

std::string state_of(const MapFileReport& report) {
  if (!report.damage.empty()) return "damaged: " + report.damage;
  return report.finished ? "whole, every checksum holds" : "sound, but the run that made it did not come to its end";
}

double megabytes(const MapFileReport& report) { return static_cast<double>(report.bytes) / 1e6; }

}  // namespace

std::string describe_map(const MapFileReport& report, const std::string& file) {
  std::string text = fmt::format("{}: map of version {}, {:.1f} MB\n  state      {}\n", file, report.version,
                                 megabytes(report), state_of(report));
  if (!report.map) return text;
  const RgbdMap& map = *report.map;
  const MapFigures figures = figures_of(map);
  const Camera& camera = map.camera;
  text += fmt::format("  made by    rastro slam --method {}\n", map.method);
  text += fmt::format(
      "  camera     {} x {} px, fx {:.6g} fy {:.6g} cx {:.6g} cy {:.6g}; depth noise {:g} + {:g} z^2 m\n", camera.width,
      camera.height, camera.fx, camera.fy, camera.cx, camera.cy, map.depth_sigma_m, map.depth_sigma_per_m2);
  text += fmt::format("  keyframes  {} in {} submap{}, {} features\n", map.keyframes.size(), figures.submaps.size(),
                      figures.submaps.size() == 1 ? "" : "s", figures.features);
  text += "  edges     ";
  for (std::size_t i = 0; i < edge_kinds.size(); ++i) text += fmt::format(" {} {}", figures.edges[i], edge_kinds[i]);
  text +=
      fmt::format("\n  way        {} poses over {:.1f} s; its keyframes span {:.2f} x {:.2f} x {:.2f} m\n",
                  map.trajectory.size(), figures.seconds, figures.extent.x(), figures.extent.y(), figures.extent.z());
  return text;
}

std::string describe_map_json(const MapFileReport& report, const std::string& file) {
  Json json{{"file", file},
            {"kind", "map"},
            {"version", report.version},
            {"bytes", report.bytes},
            {"finished", report.finished},
            {"damage", report.damage}};
  if (report.map) {
    const RgbdMap& map = *report.map;
    const MapFigures figures = figures_of(map);
    json["method"] = map.method;
    json["size_px"] = {map.camera.width, map.camera.height};
    json["fx_fy_cx_cy_px"] = {map.camera.fx, map.camera.fy, map.camera.cx, map.camera.cy};
    json["keyframes"] = map.keyframes.size();
    json["submaps"] = figures.submaps.size();
    json["features"] = figures.features;
    for (std::size_t i = 0; i < edge_kinds.size(); ++i) json["edges"][edge_kinds[i]] = figures.edges[i];
    json["poses"] = map.trajectory.size();
    json["seconds"] = figures.seconds;
    json["extent_m"] = {figures.extent.x(), figures.extent.y(), figures.extent.z()};
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rastro::cli
