// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closing/loop_correction.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "rastro/optimize/pose_graph.h"
#include "rastro/slam/orb/map/landmark_search.h"

namespace rastro {
namespace {

/// The keyframe and those covisible with it; the keyframe first.
std::vector<std::int64_t> surroundings(const MapGraph& graph, std::int64_t keyframe, int least_shared) {
  std::vector<std::int64_t> ids{keyframe};
  for (const Neighbor& n : graph.covisible(keyframe, least_shared)) ids.push_back(n.id);
  return ids;
}

/// The rigid pose with the same projections in its own unit.
SE3 rigid(const Sim3& camera_from_world) {
  return {camera_from_world.rotation(), camera_from_world.translation() / camera_from_world.scale()};
}

/// A feature of a keyframe observes a landmark: adds the observation, or fuses with the landmark it had. Returns the
/// number of fused landmarks.
int fuse_observation(MapGraph& graph, std::int64_t keyframe, std::uint32_t feature, std::int64_t landmark) {
  const std::int64_t kept = graph.current(landmark);
  const std::int64_t there = graph.keyframe(keyframe).landmarks[feature];
  if (kept < 0 || there == kept) return 0;
  if (there < 0) {
    graph.add_observation(keyframe, feature, kept);
    return 0;
  }
  graph.fuse(kept, there);
  return 1;
}

/// Searches for landmarks of the matched place in all keyframes around, whose poses are corrected by now.
int fuse_landmarks(MapGraph& graph, const OrbSlamOptions& options, const VerifiedLoop& loop,
                   const std::vector<std::int64_t>& around) {
  int fused = 0;
  for (const auto& [feature, landmark] : loop.landmarks)
    fused += fuse_observation(graph, loop.keyframe, feature, landmark);
  std::vector<std::int64_t> landmarks = landmarks_around(graph, loop.matched, options.covisible_landmarks,
                                                         static_cast<std::size_t>(options.local_keyframes));
  for (const std::int64_t id : around) {
    std::erase_if(landmarks, [&](std::int64_t landmark) { return !graph.has_landmark(landmark); });
    const MapKeyframe& keyframe = graph.keyframe(id);
    const auto matches =
        search_landmarks(graph, landmarks, *keyframe.frame, Sim3(keyframe.camera_from_world),
                         {.radius_px = options.loop_search_px, .limits = {.max_distance = options.place_hamming}});
    for (const FeatureMatch& match : matches)
      fused += fuse_observation(graph, id, match.feature, landmarks[match.subject]);
  }
  return fused;
}

/// The correction of one loop within a submap, step by step.
class LoopCorrection {
 public:
  LoopCorrection(MapGraph& graph, const OrbSlamOptions& options, const VerifiedLoop& loop)
      : graph_(graph),
        options_(options),
        loop_(loop),
        submap_(graph.keyframe(loop.keyframe).submap),
        ids_(graph.keyframe_ids(submap_)),
        around_(surroundings(graph, loop.keyframe, options.covisible_landmarks)) {
    for (const std::int64_t id : ids_) before_.emplace_back(graph.keyframe(id).camera_from_world.inverse());
    start_ = before_;
    add_known_edges();
  }

  /// Returns the number of fused landmarks.
  int run() {
    move_surroundings();
    const int fused = fuse_landmarks(graph_, options_, loop_, around_);
    add_loop_edges();
    std::vector<Sim3> after = start_;
    std::vector<std::uint8_t> fixed(ids_.size(), 0);
    fixed[held()] = 1;
    PoseGraphOptions graph_options;
    graph_options.loops = LoopModel::trusted;
    graph_options.fix_scale = graph_.sensor() != CameraKind::mono;
    optimize_pose_graph(after, edges_, fixed, graph_options);
    hold_root(after);
    take_over(after);
    return fused;
  }

 private:
  std::uint32_t index(std::int64_t id) const {
    return static_cast<std::uint32_t>(std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin());
  }
  bool is_around(std::int64_t id) const { return std::find(around_.begin(), around_.end(), id) != around_.end(); }

  std::int64_t root() const {
    const auto is_root = [&](std::int64_t id) { return graph_.keyframe(id).parent < 0; };
    const auto at = std::find_if(ids_.begin(), ids_.end(), is_root);
    return at == ids_.end() ? loop_.matched : *at;
  }

  /// The fixed keyframe: the root, or the matched keyframe if the root is among those that move.
  std::size_t held() const { return index(is_around(root()) ? loop_.matched : root()); }

  /// The root is the submap's world: if it moved, all move back with it. Relative poses stay as they are.
  void hold_root(std::vector<Sim3>& poses) const {
    const std::size_t origin = index(root());
    if (origin == held()) return;
    const Sim3 back = before_[origin] * poses[origin].inverse();
    for (Sim3& pose : poses) pose = back * pose;
    poses[origin] = before_[origin];
  }

  void add_edge(std::int64_t from, std::int64_t to, const Sim3& from_from_to) {
    edges_.push_back({.from = index(from), .to = index(to), .from_from_to = from_from_to});
  }

  /// Spanning tree, earlier loops and strong covisibility, with the relative poses before the correction.
  void add_known_edges() {
    const auto relative = [&](std::int64_t from, std::int64_t to) {
      return before_[index(from)].inverse() * before_[index(to)];
    };
    for (const std::int64_t id : ids_) {
      const MapKeyframe& keyframe = graph_.keyframe(id);
      if (keyframe.parent >= 0) add_edge(id, keyframe.parent, relative(id, keyframe.parent));
      for (const Neighbor& n : keyframe.neighbors) {
        if (n.id < id && n.id != keyframe.parent && n.shared >= options_.essential_landmarks &&
            graph_.keyframe(n.id).parent != id && graph_.keyframe(n.id).submap == submap_)
          add_edge(id, n.id, relative(id, n.id));
      }
    }
    for (const Constraint& constraint : graph_.constraints()) {
      if (graph_.keyframe(constraint.from).submap == submap_ && graph_.keyframe(constraint.to).submap == submap_)
        add_edge(constraint.from, constraint.to, relative(constraint.from, constraint.to));
    }
    for (const std::int64_t id : around_) {
      std::vector<std::int64_t>& list = known_[id];
      for (const Neighbor& n : graph_.keyframe(id).neighbors) list.push_back(n.id);
    }
  }

  /// Moves the surroundings to the poses that the loop predicts, with all landmarks they observe.
  void move_surroundings() {
    const Sim3 keyframe_from_world =
        loop_.keyframe_from_matched * Sim3(graph_.keyframe(loop_.matched).camera_from_world);
    const SE3 world_from_keyframe = graph_.keyframe(loop_.keyframe).camera_from_world.inverse();
    for (const std::int64_t id : around_) {
      MapKeyframe& keyframe = graph_.keyframe(id);
      const Sim3 camera_from_world = Sim3(keyframe.camera_from_world * world_from_keyframe) * keyframe_from_world;
      const Sim3 world_from_camera = camera_from_world.inverse();
      for (const std::int64_t landmark : keyframe.landmarks) {
        if (landmark < 0 || !moved_with_.emplace(landmark, id).second) continue;
        MapLandmark& moving = graph_.landmark(landmark);
        moving.position = world_from_camera * Eigen::Vector3d(keyframe.camera_from_world * moving.position);
      }
      start_[index(id)] = world_from_camera;
    }
    for (const std::int64_t id : around_) {
      MapKeyframe& keyframe = graph_.keyframe(id);
      const Sim3 camera_from_world = start_[index(id)].inverse();
      keyframe.camera_from_world = rigid(camera_from_world);
      keyframe.unit /= camera_from_world.scale();
    }
    for (const auto& [landmark, keyframe] : moved_with_) graph_.describe(landmark);
  }

  void add_loop_edges() {
    for (const std::int64_t id : around_) {
      const std::vector<std::int64_t>& known = known_[id];
      for (const Neighbor& n : graph_.keyframe(id).neighbors) {
        if (is_around(n.id) || std::binary_search(known.begin(), known.end(), n.id)) continue;
        if (graph_.keyframe(n.id).submap != submap_ || n.shared < options_.essential_landmarks) continue;
        if (id == loop_.keyframe && n.id == loop_.matched) continue;
        add_edge(id, n.id, start_[index(id)].inverse() * before_[index(n.id)]);
      }
    }
    add_edge(loop_.keyframe, loop_.matched, loop_.keyframe_from_matched);
  }

  /// Applies the change from the start to the optimized poses to keyframes and landmarks.
  void take_over(const std::vector<Sim3>& after) {
    std::vector<Sim3> moves;
    for (std::size_t i = 0; i < ids_.size(); ++i) moves.push_back(after[i] * start_[i].inverse());
    for (const std::int64_t landmark : graph_.landmark_ids()) {
      MapLandmark& moving = graph_.landmark(landmark);
      if (moving.observations.empty()) continue;
      if (graph_.keyframe(moving.observations.front().keyframe).submap != submap_) continue;
      const auto with = moved_with_.find(landmark);
      std::int64_t reference = with != moved_with_.end() ? with->second : moving.first_keyframe;
      if (!graph_.has_keyframe(reference)) reference = moving.observations.front().keyframe;
      moving.position = moves[index(reference)] * moving.position;
    }
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      MapKeyframe& keyframe = graph_.keyframe(ids_[i]);
      keyframe.camera_from_world = rigid(after[i].inverse());
      keyframe.unit *= moves[i].scale();
    }
    for (const std::int64_t landmark : graph_.landmark_ids()) graph_.describe(landmark);
  }

  MapGraph& graph_;
  const OrbSlamOptions& options_;
  const VerifiedLoop& loop_;
  int submap_;
  std::vector<std::int64_t> ids_;     ///< Of the submap, ascending.
  std::vector<std::int64_t> around_;  ///< Keyframes that move with the keyframe.
  std::vector<Sim3> before_, start_;  ///< world_from_camera: original, and with the surroundings moved.
  std::vector<Constraint> edges_;     ///< Between indices into ids_.
  std::map<std::int64_t, std::vector<std::int64_t>> known_;  ///< Neighbors of the surroundings before fusing.
  std::map<std::int64_t, std::int64_t> moved_with_;          ///< Landmark to keyframe.
};

/// Transforms the younger submap into the older. Returns the number of fused landmarks.
int merge_submaps(MapGraph& graph, const OrbSlamOptions& options, const VerifiedLoop& loop, LoopResult& result) {
  const MapKeyframe& keyframe = graph.keyframe(loop.keyframe);
  const MapKeyframe& matched = graph.keyframe(loop.matched);
  const Sim3 matched_world_from_keyframe_world = Sim3(matched.camera_from_world).inverse() *
                                                 loop.keyframe_from_matched.inverse() *
                                                 Sim3(keyframe.camera_from_world);
  const bool moves_keyframe = matched.submap < keyframe.submap;
  const MapKeyframe &moved = moves_keyframe ? keyframe : matched, &kept = moves_keyframe ? matched : keyframe;
  result.new_from_old =
      moves_keyframe ? matched_world_from_keyframe_world : matched_world_from_keyframe_world.inverse();
  result.scale = result.new_from_old.scale();
  result.stayed = kept.id;
  const std::vector<std::int64_t> ids = graph.keyframe_ids(moved.submap);
  graph.merge(moved.submap, kept.submap, result.new_from_old, moved.id, kept.id);
  for (const std::int64_t id : ids)
    result.transformed.emplace_back(id, graph.keyframe(id).camera_from_world.inverse().translation());
  return fuse_landmarks(graph, options, loop, surroundings(graph, loop.keyframe, options.covisible_landmarks));
}

}  // namespace

SlamEvent LoopResult::event() const {
  std::string detail = fmt::format("keyframe {} with keyframe {}: {} landmarks matched, scale {:.3f}", keyframe,
                                   matched, landmarks, scale);
  if (!merged) detail += fmt::format(", moved by {:.3f}", moved);
  return {merged ? "joined" : "loop_closed", std::move(detail)};
}

LoopResult correct_loop(MapGraph& graph, const OrbSlamOptions& options, const VerifiedLoop& loop) {
  LoopResult result;
  result.keyframe = loop.keyframe;
  result.matched = loop.matched;
  result.inliers = loop.inliers;
  result.landmarks = static_cast<int>(loop.landmarks.size());
  const MapKeyframe& keyframe = graph.keyframe(loop.keyframe);
  result.merged = keyframe.submap != graph.keyframe(loop.matched).submap;
  const Eigen::Vector3d center = keyframe.camera_from_world.inverse().translation();
  if (result.merged) {
    result.fused = merge_submaps(graph, options, loop, result);
  } else {
    result.fused = LoopCorrection(graph, options, loop).run();
    result.scale = 1.0 / loop.keyframe_from_matched.scale();
  }
  const SE3 keyframe_from_matched =
      keyframe.camera_from_world * graph.keyframe(loop.matched).camera_from_world.inverse();
  graph.constraints().push_back({.from = loop.keyframe,
                                 .to = loop.matched,
                                 .from_from_to = Sim3(keyframe_from_matched),
                                 .kind = result.merged ? ConstraintKind::merge : ConstraintKind::loop,
                                 .inliers = loop.inliers});
  if (!result.merged) result.moved = (keyframe.camera_from_world.inverse().translation() - center).norm();
  return result;
}

}  // namespace rastro
