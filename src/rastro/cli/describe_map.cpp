// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/describe_map.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "rastro/base/text.h"

namespace rastro::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 4> edge_kinds = {"way", "near", "loop", "join"};

struct MapFigures {
  std::set<int> submaps;
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();  ///< Of the places of the cameras.
  std::size_t features = 0;
  double seconds = 0.0;
};

template <typename Map>
MapFigures figures_of(const Map& map) {
  MapFigures figures;
  Eigen::AlignedBox3d box;
  for (const auto& pose : map.poses) {
    figures.submaps.insert(pose.submap);
    if (pose.submap == 0) box.extend(pose.world_from_camera.translation());
  }
  if (!box.isEmpty()) figures.extent = box.sizes();
  for (const auto& keyframe : map.keyframes) figures.features += keyframe->features.size();
  if (!map.trajectory.empty()) figures.seconds = to_seconds(map.trajectory.back().stamp - map.trajectory.front().stamp);
  return figures;
}

std::array<std::int64_t, edge_kinds.size()> edges_of(const RgbdMap& map) {
  std::array<std::int64_t, edge_kinds.size()> edges{};
  for (const PoseEdge& edge : map.edges) ++edges[static_cast<std::size_t>(edge.kind)];
  return edges;
}

constexpr const char* name_of(LandmarkSensor sensor) {
  return sensor == LandmarkSensor::mono     ? "one camera"
         : sensor == LandmarkSensor::stereo ? "two cameras"
                                            : "depth camera";
}

double observations_a_landmark(const LandmarkMap& map) {
  std::size_t count = 0;
  for (const Landmark& landmark : map.landmarks) count += landmark.observations.size();
  return map.landmarks.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(map.landmarks.size());
}

std::string state_of(const MapFileReport& report) {
  if (!report.damage.empty()) return "damaged: " + report.damage;
  return report.finished ? "whole, every checksum holds" : "sound, but the run that made it did not come to its end";
}

double megabytes(const MapFileReport& report) { return static_cast<double>(report.bytes) / 1e6; }

std::string camera_text(const Camera& camera) {
  return fmt::format("  camera     {} x {} px, fx {:.6g} fy {:.6g} cx {:.6g} cy {:.6g}", camera.width, camera.height,
                     camera.fx, camera.fy, camera.cx, camera.cy);
}

template <typename Map>
std::string keyframes_text(const Map& map, const MapFigures& figures) {
  return fmt::format("  keyframes  {} in {} submap{}, {} features\n", map.keyframes.size(), figures.submaps.size(),
                     figures.submaps.size() == 1 ? "" : "s", figures.features);
}

template <typename Map>
std::string way_text(const Map& map, const MapFigures& figures, const char* unit) {
  return fmt::format("  way        {} poses over {:.1f} s; its keyframes span {:.2f} x {:.2f} x {:.2f} {}\n",
                     map.trajectory.size(), figures.seconds, figures.extent.x(), figures.extent.y(), figures.extent.z(),
                     unit);
}

std::string made_by(const std::string& method) {
  return fmt::format("  made by    rastro slam --method {}\n", one_line(method));
}

std::string describe(const RgbdMap& map) {
  const MapFigures figures = figures_of(map);
  std::string text = made_by(map.method) + camera_text(map.camera);
  text += fmt::format("; depth noise {:g} + {:g} z^2 m\n", map.depth_sigma_m, map.depth_sigma_per_m2);
  text += keyframes_text(map, figures) + "  edges     ";
  const auto edges = edges_of(map);
  for (std::size_t i = 0; i < edge_kinds.size(); ++i) text += fmt::format(" {} {}", edges[i], edge_kinds[i]);
  return text + "\n" + way_text(map, figures, "m");
}

std::string scale_text(const MapScale& scale) {
  if (!scale.metric) return "arbitrary: lengths are in a unit of the map's own; 'rastro scale' makes them metres";
  std::string text = "metres, from " + one_line(scale.origin);
  return scale.relative_sigma > 0.0 ? text + fmt::format(" (sigma {:.2g} %)", 100.0 * scale.relative_sigma) : text;
}

std::string describe(const LandmarkMap& map) {
  const MapFigures figures = figures_of(map);
  std::string text = made_by(map.method) + camera_text(map.camera);
  text += fmt::format("; {}", name_of(map.sensor));
  if (map.baseline > 0.0) text += fmt::format(", {:.4g} m apart", map.baseline);
  text += fmt::format("\n  scale      {}\n", scale_text(map.scale)) + keyframes_text(map, figures);
  text += fmt::format("  landmarks  {}, seen {:.1f} times each; {} ties by loops and joins\n", map.landmarks.size(),
                      observations_a_landmark(map), map.ties.size());
  return text + way_text(map, figures, map.scale.metric ? "m" : "units");
}

template <typename Map>
void add_common(Json& json, const Map& map) {
  const MapFigures figures = figures_of(map);
  json["method"] = map.method;
  json["size_px"] = {map.camera.width, map.camera.height};
  json["fx_fy_cx_cy_px"] = {map.camera.fx, map.camera.fy, map.camera.cx, map.camera.cy};
  json["keyframes"] = map.keyframes.size();
  json["submaps"] = figures.submaps.size();
  json["features"] = figures.features;
  json["poses"] = map.trajectory.size();
  json["seconds"] = figures.seconds;
  json["extent_m"] = {figures.extent.x(), figures.extent.y(), figures.extent.z()};
}

void add_landmarks(Json& json, const LandmarkMap& map) {
  add_common(json, map);
  if (!map.scale.metric) {
    json["extent_units"] = json["extent_m"];
    json.erase("extent_m");
  }
  json["sensor"] = name_of(map.sensor);
  json["baseline_m"] = map.baseline;
  json["scale"] = {
      {"metric", map.scale.metric}, {"relative_sigma", map.scale.relative_sigma}, {"from", map.scale.origin}};
  json["landmarks"] = map.landmarks.size();
  json["observations_a_landmark"] = observations_a_landmark(map);
  json["ties"] = map.ties.size();
}

}  // namespace

std::string describe_map(const MapFileReport& report, const std::string& file) {
  std::string text = fmt::format("{}: map of version {}, {:.1f} MB\n  state      {}\n", file, report.version,
                                 megabytes(report), state_of(report));
  if (report.map) text += describe(*report.map);
  if (report.landmark_map) text += describe(*report.landmark_map);
  return text;
}

std::string describe_map_json(const MapFileReport& report, const std::string& file) {
  Json json{{"file", file},
            {"kind", report.landmark_map ? "map of landmarks" : "map"},
            {"version", report.version},
            {"bytes", report.bytes},
            {"finished", report.finished},
            {"damage", report.damage}};
  if (report.landmark_map) add_landmarks(json, *report.landmark_map);
  if (report.map) {
    add_common(json, *report.map);
    const auto edges = edges_of(*report.map);
    for (std::size_t i = 0; i < edge_kinds.size(); ++i) json["edges"][edge_kinds[i]] = edges[i];
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rastro::cli
