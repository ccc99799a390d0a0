// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/scene_writer.h"

#include <nlohmann/json.hpp>

#include "rastro/viewer/block_writer.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;
using Body = detail::BlockBody;

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
    if (points.tiles) json["tiles"] = tiles_json(*points.tiles);
    return json;
  }
  Json tiles_json(const SceneTiles& tiles) const {
    return {{"layer", tiles.layer},
            {"count", tiles.count},
            {"cubes", body.put(tiles.cubes)},
            {"spacings", body.put(tiles.spacings)},
            {"parents", body.put(tiles.parents)},
            {"counts", body.put(tiles.counts)}};
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

Json lengths_json(const std::vector<SceneLength>& lengths) {
  Json json = Json::array();
  for (const SceneLength& each : lengths)
    json.push_back({{"name", each.name}, {"a", each.a}, {"b", each.b}, {"length", each.length}, {"sigma", each.sigma}});
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
  if (!scene.lengths.empty()) json["lengths"] = lengths_json(scene.lengths);
  json["images"] = images_json(scene.images, body);
  return json;
}

}  // namespace

const std::vector<std::string>& scene_state_names() {
  static const std::vector<std::string> names = {"tracking", "weak", "lost", "relocalized", "initializing", "unknown"};
  return names;
}

std::string scene_bytes(const ViewScene& scene) {
  Body body;
  const Json header = header_of(scene, body);
  return detail::block_of(header, body);
}

}  // namespace rastro
