// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closing/global_bundle_adjustment.h"

#include <fmt/format.h>

#include <map>
#include <set>

namespace rastro {
namespace {

BundleProblem problem_of(const MapGraph& graph, int submap, double pixel_sigma) {
  std::vector<std::int64_t> free, fixed;
  for (const std::int64_t id : graph.keyframe_ids(submap)) (graph.keyframe(id).parent < 0 ? fixed : free).push_back(id);
  return bundle_problem(graph, free, fixed, pixel_sigma);
}

/// The correction around each keyframe: new_world_from_old_world.
class Moves {
 public:
  Moves(const MapGraph& graph, const BundleProblem& problem) : graph_(graph) {
    for (std::size_t i = 0; i < problem.keyframes.size(); ++i) {
      const std::int64_t id = problem.keyframes[i];
      if (graph.has_keyframe(id))
        moves_.emplace(id, problem.bundle.camera_from_world[i].inverse() * graph.keyframe(id).camera_from_world);
    }
  }

  /// That of the keyframe or of its nearest adjusted ancestor.
  SE3 of(std::int64_t keyframe) const {
    for (std::int64_t id = keyframe; id >= 0; id = graph_.keyframe(id).parent) {
      const auto at = moves_.find(id);
      if (at != moves_.end()) return at->second;
    }
    return {};
  }

 private:
  const MapGraph& graph_;
  std::map<std::int64_t, SE3> moves_;
};

}  // namespace

GlobalBundleAdjustment::GlobalBundleAdjustment(const MapGraph& graph, int submap, double pixel_sigma)
    : problem_(problem_of(graph, submap, pixel_sigma)) {}

void GlobalBundleAdjustment::run(int iterations, const std::atomic<bool>* stop, TaskPool* pool) {
  if (problem_.bundle.observations.empty()) return;
  const auto stopped = [&] { return canceled_.load() || (stop != nullptr && stop->load()); };
  adjust_bundle_problem(problem_, iterations, stopped, pool);
}

void GlobalBundleAdjustment::apply(MapGraph& graph) const {
  const Moves moves(graph, problem_);
  std::map<std::int64_t, SE3> moved;
  std::set<int> submaps;
  for (const std::int64_t id : problem_.keyframes) {
    if (graph.has_keyframe(id)) submaps.insert(graph.keyframe(id).submap);
  }
  for (const int submap : submaps) {
    for (const std::int64_t id : graph.keyframe_ids(submap)) moved.emplace(id, moves.of(id));
  }
  for (std::size_t i = 0; i < problem_.landmarks.size(); ++i) {
    if (graph.has_landmark(problem_.landmarks[i]))
      graph.landmark(problem_.landmarks[i]).position = problem_.bundle.points[i];
  }
  const std::set<std::int64_t> adjusted(problem_.landmarks.begin(), problem_.landmarks.end());
  for (const std::int64_t id : graph.landmark_ids()) {
    MapLandmark& landmark = graph.landmark(id);
    if (landmark.observations.empty() || adjusted.contains(id)) continue;
    auto with = moved.find(landmark.first_keyframe);
    if (with == moved.end()) with = moved.find(landmark.observations.front().keyframe);
    if (with != moved.end()) landmark.position = with->second * landmark.position;
  }
  for (const auto& [id, move] : moved) {
    MapKeyframe& keyframe = graph.keyframe(id);
    keyframe.camera_from_world = keyframe.camera_from_world * move.inverse();
  }
  drop_outliers(graph, problem_);
}

std::string GlobalBundleAdjustment::detail() const {
  return fmt::format("{} keyframes, {} landmarks, {} of {} observations removed", problem_.keyframes.size(),
                     problem_.landmarks.size(), problem_.outliers.size(),
                     problem_.outliers.size() + problem_.seen.size());
}

}  // namespace rastro
