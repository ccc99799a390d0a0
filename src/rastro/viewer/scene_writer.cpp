// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/scene_writer.h"

#include <bit>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t alignment = 8;  // of every array, so that the page can view them in place

template <typename Number>
constexpr const char* type_name() {
  if constexpr (std::is_same_v<Number, float>) return "f32";
  if constexpr (std::is_same_v<Number, double>) return "f64";
  if constexpr (std::is_same_v<Number, std::uint8_t>) return "u8";
  if constexpr (std::is_same_v<Number, std::uint32_t>) return "u32";
  if constexpr (std::is_same_v<Number, std::int32_t>) return "i32";
}

/// The arrays behind the header.
class Body {
 public:
  template <typename Number>
  Json put(const std::vector<Number>& numbers) {
    static_assert(std::endian::native == std::endian::little, "arrays are little endian");
    const std::size_t offset = bytes_.size();
    bytes_.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
    bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment, '\0');
    return {{"offset", offset}, {"type", type_name<Number>()}, {"count", numbers.size()}};
  }
  /// Adds the array to an object, unless it is empty.
  template <typename Number>
  void put_if_any(Json& object, const char* name, const std::vector<Number>& numbers) {
    if (!numbers.empty()) object[name] = put(numbers);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

Json frames_json(const SceneFrames& frames, Body& body) {
  Json json;
  json["stamps"] = body.put(frames.stamps_s);
  json["positions"] = body.put(frames.positions);
  json["orientations"] = body.put(frames.orientations);
  body.put_if_any(json, "online", frames.online);
  body.put_if_any(json, "states", frames.states);
  body.put_if_any(json, "sigmas", frames.sigmas);
  body.put_if_any(json, "errors", frames.errors);
  body.put_if_any(json, "truth", frames.truth);
  body.put_if_any(json, "milliseconds", frames.milliseconds);
  return json;
}

Json keyframes_json(const SceneKeyframes& keyframes, Body& body) {
  Json json;
  json["ids"] = body.put(keyframes.ids);
  json["stamps"] = body.put(keyframes.stamps_s);
  json["poses"] = body.put(keyframes.poses);
  json["sessions"] = body.put(keyframes.sessions);
  json["submaps"] = body.put(keyframes.submaps);
  return json;
}

/// One layer of each kind.
struct LayerWriter {
  Body& body;

  Json operator()(const SceneEdges& edges) const {
    return {{"kind", "edges"}, {"name", edges.name}, {"pairs", body.put(edges.pairs)}};
  }
  Json operator()(const ScenePoints& points) const {
    Json json{{"kind", "points"}, {"name", points.name}, {"positions", body.put(points.positions)}};
    body.put_if_any(json, "colors", points.colors);
    body.put_if_any(json, "sigmas", points.sigmas);
    body.put_if_any(json, "keyframes", points.keyframes);
    return json;
  }
  Json operator()(const SceneMesh& mesh) const {
    Json json{{"kind", "mesh"}, {"name", mesh.name}, {"positions", body.put(mesh.positions)}};
    body.put_if_any(json, "colors", mesh.colors);
    json["triangles"] = body.put(mesh.triangles);
    return json;
  }
  Json operator()(const SceneCubes& cubes) const {
    Json json{{"kind", "cubes"}, {"name", cubes.name}, {"centers", body.put(cubes.centers)}};
    json["sizes"] = body.put(cubes.sizes);
    body.put_if_any(json, "colors", cubes.colors);
    return json;
  }
  Json operator()(const SceneGrid& grid) const {
    return {{"kind", "grid"},    {"name", grid.name},     {"width", grid.width},          {"height", grid.height},
            {"cell", grid.cell}, {"origin", grid.origin}, {"cells", body.put(grid.cells)}};
  }
  Json operator()(const SceneEllipsoids& ellipsoids) const {
    return {{"kind", "ellipsoids"},
            {"name", ellipsoids.name},
            {"centers", body.put(ellipsoids.centers)},
            {"axes", body.put(ellipsoids.axes)}};
  }
};

Json sessions_json(const std::vector<SceneSession>& sessions) {
  Json json = Json::array();
  for (const SceneSession& each : sessions)
    json.push_back(
        {{"id", each.id}, {"robot", each.robot}, {"name", each.name}, {"first", each.first_s}, {"last", each.last_s}});
  return json;
}

Json events_json(const std::vector<SceneEvent>& events) {
  Json json = Json::array();
  for (const SceneEvent& each : events)
    json.push_back({{"frame", each.frame}, {"stamp", each.stamp_s}, {"kind", each.kind}, {"detail", each.detail}});
  return json;
}

Json images_json(const std::vector<SceneImage>& images, Body& body) {
  Json json = Json::array();
  for (const SceneImage& each : images)
    json.push_back(
        {{"keyframe", each.keyframe}, {"width", each.width}, {"height", each.height}, {"jpeg", body.put(each.jpeg)}});
  return json;
}

Json camera_json(const SceneCamera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

Json header_of(const ViewScene& scene, Body& body) {
  Json json{{"format", "rastro-scene"}, {"version", 1}, {"title", scene.title}, {"method", scene.method}};
  json["revision"] = scene.revision;
  json["scale"] = {
      {"kind", scene.metric ? "metric" : "arbitrary"}, {"sigma", scene.scale_sigma}, {"origin", scene.scale_origin}};
  json["up"] = scene.up;
  json["planar"] = scene.planar;
  json["sessions"] = sessions_json(scene.sessions);
  if (!scene.frames.stamps_s.empty()) json["frames"] = frames_json(scene.frames, body);
  json["state_names"] = scene_state_names();
  json["events"] = events_json(scene.events);
  json["keyframes"] = keyframes_json(scene.keyframes, body);
  if (scene.camera) json["camera"] = camera_json(*scene.camera);
  json["layers"] = Json::array();
  for (const SceneLayer& layer : scene.layers) json["layers"].push_back(std::visit(LayerWriter{body}, layer));
  json["images"] = images_json(scene.images, body);
  return json;
}

}  // namespace

const std::vector<std::string>& scene_state_names() {
  static const std::vector<std::string> names = {"tracking", "weak", "lost", "relocalized", "initializing", "unknown"};
  return names;
}

std::string scene_bytes(const ViewScene& scene) {
  constexpr std::size_t length_bytes = sizeof(std::uint32_t);
  Body body;
  // Names of files may be no UTF-8.
  std::string header = header_of(scene, body).dump(-1, ' ', false, Json::error_handler_t::replace);
  header.resize((length_bytes + header.size() + alignment - 1) / alignment * alignment - length_bytes, ' ');
  RASTRO_CHECK(header.size() < (std::size_t{1} << 31), "the header of a scene is small");
  const auto length = static_cast<std::uint32_t>(header.size());
  std::string bytes(reinterpret_cast<const char*>(&length), length_bytes);
  bytes.reserve(length_bytes + header.size() + body.bytes().size());
  return bytes.append(header).append(body.bytes());
}

}  // namespace rastro
