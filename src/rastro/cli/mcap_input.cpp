// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/mcap_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <variant>

#include "rastro/base/error.h"
#include "rastro/base/version.h"
#include "rastro/map/graph/sessions.h"
#include "rastro/map/images/image_layer.h"

namespace rastro::cli {
namespace {

Eigen::Vector3d vector_of(const std::vector<float>& numbers, std::size_t row) {
  return Eigen::Vector3f(numbers[3 * row], numbers[3 * row + 1], numbers[3 * row + 2]).cast<double>();
}

/// One layer of each kind; triangles and cubes are for pages only.
struct LayerTaker {
  McapRun& run;

  void operator()(const SceneEdges& edges) const {
    McapRun::Edges taken{edges.name, {}};
    for (std::size_t k = 0; k + 1 < edges.pairs.size(); k += 2)
      taken.pairs.push_back({edges.pairs[k], edges.pairs[k + 1]});
    run.edges.push_back(std::move(taken));
  }
  void operator()(const ScenePoints& points) const {
    run.points.push_back({points.name, points.positions, points.colors, points.sigmas});
  }
  void operator()(const SceneGrid& grid) const {
    run.grids.push_back({grid.name, grid.width, grid.height, grid.cell, grid.origin, grid.cells});
  }
  void operator()(const SceneEllipsoids& ellipsoids) const {
    McapRun::Ellipsoids taken{ellipsoids.name, {}, {}};
    for (std::size_t row = 0; row < ellipsoids.centers.size() / 3; ++row) {
      Eigen::Matrix3d axes;
      for (std::size_t axis = 0; axis < 3; ++axis)
        axes.col(static_cast<Eigen::Index>(axis)) = vector_of(ellipsoids.axes, 3 * row + axis);
      taken.centers.push_back(vector_of(ellipsoids.centers, row));
      taken.covariances.push_back(axes * axes.transpose());
    }
    run.ellipsoids.push_back(std::move(taken));
  }
  void operator()(const SceneMesh&) const {}
  void operator()(const SceneCubes&) const {}
};

bool is_shown(const Keyframe& keyframe, int submap) { return submap < 0 || keyframe.submap == submap; }

/// ROBOT/SESSION/NUMBER where there are several sessions; some methods number all keyframes of a map on.
std::string keyframe_name(const Map& map, const Keyframe& keyframe, std::optional<std::size_t> session) {
  const KeyframeOrigin origin = origin_of(keyframe.id);
  if (map.sessions.size() < 2) return fmt::format("{}", origin.number);
  const int number = session ? map.sessions[*session].session : origin.session;
  return fmt::format("{}/{}/{}", origin.robot, number, origin.number);
}

/// In the order of the scene's rows.
void add_keyframes(const Map& map, int submap, McapRun& run) {
  const auto sessions = sessions_of_keyframes(map);
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    if (is_shown(keyframe, submap))
      run.keyframes.push_back(
          {keyframe_name(map, keyframe, sessions[k]), {keyframe.stamp, keyframe.world_from_camera}});
  }
}

void add_camera(const Map& map, McapRun& run) {
  run.of_camera = !map.cameras.empty() && map.cameras.front().kind != CameraKind::none;
  if (!run.of_camera) return;
  const Camera& camera = map.cameras.front().intrinsics;
  if (camera.width > 0 && camera.height > 0 && camera.fx > 0.0) run.camera = camera;
}

void add_images(const Map& map, int submap, McapRun& run) {
  const auto layer = map.layer<ImageLayer>();
  if (!layer) return;
  for (const KeyframeId id : layer->keyframes) {
    const Keyframe* keyframe = map.find(id);
    if (!keyframe || !is_shown(*keyframe, submap)) continue;
    run.images.push_back({keyframe->stamp, [store = layer->store, id] {
                            const std::vector<std::uint8_t> color = store->read(id).color;
                            return std::string(color.begin(), color.end());
                          }});
  }
}

/// With --submap all those of each submap in its own frame, as the keyframes are.
Trajectory trajectory_in(const ExportInput& input, int submap) {
  if (!input.map || (submap >= 0 && !input.trajectory.empty())) return input.trajectory;
  std::set<int> submaps;
  for (const Keyframe& keyframe : input.map->keyframes)
    if (is_shown(keyframe, submap)) submaps.insert(keyframe.submap);
  return trajectory_of(*input.map, submaps);
}

/// Events, and changes of the state that no event tells.
std::vector<McapRun::Note> notes_in(const RunRecord& record) {
  std::multimap<std::int64_t, const RunRecord::Event*> events;
  for (const RunRecord::Event& event : record.events) events.emplace(event.frame, &event);
  std::vector<McapRun::Note> notes;
  std::string state;
  for (const RunRecord::Frame& frame : record.frames) {
    const auto [begin, end] = events.equal_range(frame.frame);
    const bool told = std::any_of(begin, end, [&](const auto& each) { return each.second->kind == frame.state; });
    if (frame.state != state && !told) notes.push_back({frame.stamp, mcap_level_of(frame.state), frame.state, ""});
    for (auto each = begin; each != end; ++each)
      notes.push_back({frame.stamp, mcap_level_of(each->second->kind), each->second->kind, each->second->detail});
    state = frame.state;
  }
  return notes;
}

void add_facts(const ExportInput& input, const ViewScene& scene, McapRun& run) {
  run.facts = {{"name", scene.title}, {"program", "rastro " + version().number}, {"unit", unit_of(input)}};
  run.facts["frames"] = "upright: z up; world: that of the map; " +
                        std::string(run.of_camera ? "camera: x right, y down, z ahead" : "body: x ahead, y left, z up");
  if (!input.map) return;
  run.facts["method"] = scene.method;
  run.facts["revision"] = fmt::format("{}", scene.revision);
  if (!scene.scale_origin.empty()) run.facts["scale"] = scene.scale_origin;
  if (scene.scale_sigma > 0.0) run.facts["scale_sigma"] = fmt::format("{:.6g}", scene.scale_sigma);
}

}  // namespace

McapRun::Level mcap_level_of(const std::string& kind) {
  if (kind == "lost") return McapRun::Level::error;
  return kind == "weak" ? McapRun::Level::warning : McapRun::Level::info;
}

McapRun mcap_run_of(const ExportInput& input, const RunRecord& record, const ViewScene& scene, int submap) {
  McapRun run;
  run.of_camera = !scene.planar;
  run.up = {scene.up[0], scene.up[1], scene.up[2]};
  run.trajectory = trajectory_in(input, submap);
  if (submap <= 0) run.online = record.online;
  for (const RunRecord::Truth& truth : record.truth) run.truth.push_back(truth.position);
  run.notes = notes_in(record);
  if (input.map && !input.map->keyframes.empty()) {
    add_keyframes(*input.map, submap, run);
    add_camera(*input.map, run);
    add_images(*input.map, submap, run);
  }
  for (const SceneLayer& layer : scene.layers) std::visit(LayerTaker{run}, layer);
  add_facts(input, scene, run);
  return run;
}

}  // namespace rastro::cli
