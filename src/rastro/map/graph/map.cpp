// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/map/layer_type.h"

namespace rastro {
namespace {

bool is_finite(const SE3& pose) {
  return pose.translation().allFinite() && pose.rotation().quaternion().coeffs().allFinite();
}

std::string fault_of(const Map& map, const Keyframe& keyframe) {
  const bool no_camera = keyframe.camera == 0 && map.cameras.empty();
  if (!no_camera && (keyframe.camera < 0 || static_cast<std::size_t>(keyframe.camera) >= map.cameras.size()))
    return "has a keyframe of a camera that is not there";
  if (!is_finite(keyframe.world_from_camera)) return "has a keyframe without a pose";
  return keyframe.submap < 0 ? "has a keyframe of a submap that cannot be" : "";
}

std::string fault_of(const Map& map, const Constraint& constraint) {
  if (!map.index_of(constraint.from) || !map.index_of(constraint.to))
    return "has a constraint to a keyframe that is not there";
  return fault_of(constraint);
}

std::string fault_of_keyframes(const Map& map) {
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    if (map.keyframes[k].id < 0 || (k > 0 && map.keyframes[k].id <= map.keyframes[k - 1].id))
      return "has keyframes out of order";
    if (std::string fault = fault_of(map, map.keyframes[k]); !fault.empty()) return fault;
  }
  return {};
}

/// A keyframe whose parents do not lead to a root is in a cycle.
std::string fault_of_tree(const Map& map) {
  enum : std::uint8_t { unknown, on_path, ends };
  std::vector<std::uint8_t> state(map.keyframes.size(), unknown);
  for (std::size_t start = 0; start < map.keyframes.size(); ++start) {
    std::vector<std::size_t> path;
    std::size_t at = start;
    while (state[at] == unknown) {
      state[at] = on_path;
      path.push_back(at);
      if (map.keyframes[at].parent == no_keyframe) break;
      const auto parent = map.index_of(map.keyframes[at].parent);
      if (!parent) return "has a spanning tree that leads to a keyframe that is not there";
      at = *parent;
      if (state[at] == on_path) return "has a spanning tree with a ring in it";
    }
    for (const std::size_t k : path) state[k] = ends;
  }
  return {};
}

}  // namespace

std::string fault_of(const Constraint& constraint) {
  const bool finite = is_finite(constraint.rigid()) && std::isfinite(constraint.from_from_to.scale()) &&
                      constraint.information.allFinite() && std::isfinite(constraint.weight);
  if (!finite) return "has a constraint whose numbers are not finite";
  if (constraint.from == constraint.to) return "has a constraint of a keyframe to itself";
  // As optimization takes its root. One that overflows has a root that is not finite.
  const Eigen::LLT<Matrix6d> root(0.5 * (constraint.information + constraint.information.transpose()));
  const bool positive = root.info() == Eigen::Success && root.matrixLLT().allFinite();
  return positive ? "" : "has a constraint whose information is not positive definite";
}

const char* name_of(ConstraintKind kind) {
  constexpr const char* names[constraint_kinds] = {"odometry", "proximity", "loop", "merge", "inter_robot"};
  return names[static_cast<std::size_t>(kind)];
}

const char* name_of(CameraKind kind) {
  constexpr const char* names[] = {"one camera", "two cameras", "depth camera", "no camera"};
  return names[static_cast<std::size_t>(kind)];
}

std::optional<std::size_t> Map::index_of(KeyframeId id) const {
  const auto found = std::lower_bound(keyframes.begin(), keyframes.end(), id,
                                      [](const Keyframe& keyframe, KeyframeId wanted) { return keyframe.id < wanted; });
  if (found == keyframes.end() || found->id != id) return std::nullopt;
  return static_cast<std::size_t>(found - keyframes.begin());
}

const Keyframe* Map::find(KeyframeId id) const {
  const auto index = index_of(id);
  return index ? &keyframes[*index] : nullptr;
}

Trajectory keyframe_trajectory(const Map& map, int submap) {
  Trajectory trajectory;
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.submap == submap) trajectory.push_back({keyframe.stamp, keyframe.world_from_camera});
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  return trajectory;
}

std::optional<MapFrame> frame_in(const Map& map, const StampedPose& world_from_camera, int submap) {
  const Keyframe* reference = nullptr;
  for (const Keyframe& keyframe : map.keyframes) {
    if (keyframe.submap != submap) continue;
    if (!reference || (keyframe.stamp <= world_from_camera.stamp && keyframe.stamp >= reference->stamp) ||
        (reference->stamp > world_from_camera.stamp && keyframe.stamp < reference->stamp))
      reference = &keyframe;
  }
  if (!reference) return std::nullopt;
  return MapFrame{world_from_camera.stamp, reference->id,
                  reference->world_from_camera.inverse() * world_from_camera.world_from_body};
}

const MapScale& scale_of(const Map& map) {
  static const MapScale arbitrary{false, 0.0, "arbitrary"};
  return map.sessions.empty() ? arbitrary : map.sessions.front().scale;
}

const MapCamera& camera_of(const Map& map, const std::string& where) {
  if (map.cameras.empty()) throw Error("the map has no camera", where, "give a map made with a camera");
  return map.cameras.front();
}

std::string contradiction_in(const Map& map) {
  if (std::string fault = fault_of_keyframes(map); !fault.empty()) return fault;
  if (std::string fault = fault_of_tree(map); !fault.empty()) return fault;
  for (const Constraint& constraint : map.constraints)
    if (std::string fault = fault_of(map, constraint); !fault.empty()) return fault;
  for (const MapFrame& frame : map.frames)
    if (!map.index_of(frame.keyframe)) return "has a frame relative to a keyframe that is not there";
  for (const auto& [name, layer] : map.layers.all()) {
    const LayerType* type = layer_type(name);
    if (!type) continue;
    if (std::string fault = type->contradiction(map, *layer); !fault.empty()) return fault;
  }
  return {};
}

}  // namespace rastro
