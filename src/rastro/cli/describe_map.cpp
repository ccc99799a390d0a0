// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/describe_map.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "rastro/base/text.h"
#include "rastro/cli/map_sessions.h"
#include "rastro/map/graph/sessions.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/layer_type.h"

namespace rastro::cli {
namespace {

using Json = nlohmann::ordered_json;

struct MapFigures {
  std::size_t submaps = 0, poses = 0;
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();  ///< Of the keyframes of submap 0.
  double seconds = 0.0;
};

MapFigures figures_of(const Map& map) {
  MapFigures figures;
  Eigen::AlignedBox3d box;
  std::set<int> submaps;
  for (const Keyframe& keyframe : map.keyframes) {
    submaps.insert(keyframe.submap);
    if (keyframe.submap == 0) box.extend(keyframe.world_from_camera.translation());
  }
  figures.submaps = submaps.size();
  if (!box.isEmpty()) figures.extent = box.sizes();
  const auto add = [&figures](const Trajectory& trajectory) {
    figures.poses += trajectory.size();
    if (!trajectory.empty()) figures.seconds += to_seconds(trajectory.back().stamp - trajectory.front().stamp);
  };
  if (!sessions_overlap(map)) {
    add(trajectory_of(map));
  } else {
    for (std::size_t session = 0; session < map.sessions.size(); ++session) add(trajectory_of_session(map, session));
  }
  return figures;
}

std::array<std::int64_t, constraint_kinds> constraints_of(const Map& map) {
  std::array<std::int64_t, constraint_kinds> counts{};
  for (const Constraint& constraint : map.constraints) ++counts[static_cast<std::size_t>(constraint.kind)];
  return counts;
}

const char* kind_name(std::size_t kind) { return name_of(static_cast<ConstraintKind>(kind)); }

std::string state_of(const MapFileReport& report) {
  if (!report.damage.empty()) return "damaged: " + report.damage;
  return report.finished ? "complete, every checksum is valid"
                         : "valid, but the run that made it did not end regularly";
}

double megabytes(std::uintmax_t bytes) { return static_cast<double>(bytes) / 1e6; }

std::string row(const std::string& name, const std::string& text) { return fmt::format("  {:<11} {}\n", name, text); }

/// Whoever copies the map without it has lost what the run wrote last.
std::string log_row(const MapFileReport& report, const std::string& file) {
  if (report.log_bytes == 0) return "";
  return row("log", fmt::format("{}-wal, {:.1f} MB, is a part of the map: copy both; 'rastro recover' makes one file",
                                std::filesystem::path(file).filename().string(), megabytes(report.log_bytes)));
}

/// Of a pair it is only where its map has depth images.
bool has_depth_noise(const Map& map, const MapCamera& camera) {
  return camera.kind == CameraKind::depth || (camera.kind == CameraKind::stereo && map.layer<ImageLayer>());
}

std::string camera_text(const Map& map, const MapCamera& camera) {
  const Camera& k = camera.intrinsics;
  std::string text = fmt::format("{} x {} px, fx {:.6g} fy {:.6g} cx {:.6g} cy {:.6g}; {}", k.width, k.height, k.fx,
                                 k.fy, k.cx, k.cy, name_of(camera.kind));
  if (camera.baseline > 0.0) text += fmt::format(", baseline {:.4g} m", camera.baseline);
  if (has_depth_noise(map, camera))
    text += fmt::format(", depth noise {:g} + {:g} z^2 m", camera.depth_noise.sigma_m, camera.depth_noise.sigma_per_m2);
  return text;
}

std::string scale_text(const MapScale& scale) {
  if (!scale.metric) return "arbitrary: the map is up to scale; 'rastro scale' makes it metric";
  std::string text = "meters, from " + one_line(scale.origin);
  return scale.relative_sigma > 0.0 ? text + fmt::format(" (sigma {:.2g} %)", 100.0 * scale.relative_sigma) : text;
}

std::string constraints_text(const Map& map) {
  const auto counts = constraints_of(map);
  std::string text;
  for (std::size_t kind = 0; kind < counts.size(); ++kind)
    if (counts[kind] > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[kind], kind_name(kind));
  return text.empty() ? "none" : text;
}

std::string layer_text(const Map& map, const std::string& name, const Layer& layer) {
  const LayerType* type = layer_type(name);
  return type ? type->describe(map, layer).text : "kept, unknown to this program";
}

std::string sessions_text(const Map& map) {
  const auto shares = session_shares(map);
  std::string text = row("sessions", fmt::format("{}", map.sessions.size()));
  for (std::size_t s = 0; s < shares.size(); ++s)
    text += row(fmt::format("session {}", s), session_text(map.sessions[s], shares[s]));
  return text;
}

std::string describe(const Map& map) {
  const MapFigures figures = figures_of(map);
  std::string text = row("made by", "rastro slam --method " + one_line(map.method));
  for (const MapCamera& camera : map.cameras) text += row("camera", camera_text(map, camera));
  text += row("scale", scale_text(scale_of(map)));
  if (map.sessions.size() > 1) text += sessions_text(map);
  text += row("keyframes",
              fmt::format("{} in {} submap{}", map.keyframes.size(), figures.submaps, figures.submaps == 1 ? "" : "s"));
  text += row("constraints", constraints_text(map));
  for (const auto& [name, layer] : map.layers.all()) text += row(one_line(name), layer_text(map, name, *layer));
  return text +
         row("trajectory", fmt::format("{} poses in {:.1f} s; extent of the keyframes {:.2f} x {:.2f} x {:.2f} {}",
                                       figures.poses, figures.seconds, figures.extent.x(), figures.extent.y(),
                                       figures.extent.z(), scale_of(map).metric ? "m" : "units"));
}

Json camera_json(const Map& map, const MapCamera& camera) {
  const Camera& k = camera.intrinsics;
  Json json{{"sensor", name_of(camera.kind)},
            {"size_px", {k.width, k.height}},
            {"fx_fy_cx_cy_px", {k.fx, k.fy, k.cx, k.cy}},
            {"baseline_m", camera.baseline}};
  if (has_depth_noise(map, camera)) {
    json["depth_sigma_m"] = camera.depth_noise.sigma_m;
    json["depth_sigma_per_m2"] = camera.depth_noise.sigma_per_m2;
  }
  return json;
}

/// Counts stay integers.
Json number_json(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return static_cast<double>(whole) == value ? Json(whole) : Json(value);
}

Json sessions_json(const Map& map) {
  const auto shares = session_shares(map);
  Json list = Json::array();
  for (std::size_t s = 0; s < shares.size(); ++s) {
    const MapSession& session = map.sessions[s];
    list.push_back({{"robot", session.robot},
                    {"session", session.session},
                    {"recording", session.recording},
                    {"first_stamp_s", to_seconds(session.first_stamp)},
                    {"last_stamp_s", to_seconds(session.last_stamp)},
                    {"keyframes", shares[s].keyframes},
                    {"submaps", shares[s].submaps}});
  }
  return list;
}

void add_map(Json& json, const Map& map) {
  const MapFigures figures = figures_of(map);
  json["method"] = map.method;
  json["cameras"] = Json::array();
  for (const MapCamera& camera : map.cameras) json["cameras"].push_back(camera_json(map, camera));
  const MapScale& scale = scale_of(map);
  json["scale"] = {{"metric", scale.metric}, {"relative_sigma", scale.relative_sigma}, {"from", scale.origin}};
  json["sessions"] = map.sessions.size();
  json["session_list"] = sessions_json(map);
  json["keyframes"] = map.keyframes.size();
  json["submaps"] = figures.submaps;
  json["poses"] = figures.poses;
  json["seconds"] = figures.seconds;
  json[scale.metric ? "extent_m" : "extent_units"] = {figures.extent.x(), figures.extent.y(), figures.extent.z()};
  const auto counts = constraints_of(map);
  for (std::size_t kind = 0; kind < counts.size(); ++kind) json["constraints"][kind_name(kind)] = counts[kind];
  json["layers"] = Json::array();
  for (const auto& [name, layer] : map.layers.all()) {
    json["layers"].push_back(name);
    if (const LayerType* type = layer_type(name))
      for (const auto& [figure, value] : type->describe(map, *layer).numbers) json[figure] = number_json(value);
  }
}

}  // namespace

std::string describe_map(const MapFileReport& report, const std::string& file) {
  const std::string version = report.version > 0 ? fmt::format(" of version {}", report.version) : "";  // 0: cut off
  const std::string head = fmt::format("{}: map{}, {:.1f} MB\n", file, version, megabytes(report.bytes));
  return head + row("state", state_of(report)) + log_row(report, file) + (report.map ? describe(*report.map) : "");
}

std::string describe_map_json(const MapFileReport& report, const std::string& file) {
  Json json{{"file", file},
            {"kind", "map"},
            {"version", report.version},
            {"bytes", report.bytes},
            {"log_bytes", report.log_bytes},
            {"finished", report.finished},
            {"damage", report.damage}};
  if (report.map) add_map(json, *report.map);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rastro::cli
