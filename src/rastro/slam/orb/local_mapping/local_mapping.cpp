// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/local_mapping.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/math/median.h"
#include "rastro/slam/orb/local_mapping/bundle_problem.h"
#include "rastro/slam/orb/local_mapping/map_thinning.h"

namespace rastro {

LocalMapping::LocalMapping(const OrbSlamOptions& options, MapGraph& graph, TaskPool* pool,
                           const std::atomic<bool>* stop, const DirectAlignment* direct)
    : options_(options), graph_(graph), pool_(pool), stop_(stop), direct_(direct, graph) {}

bool LocalMapping::initialize(const std::shared_ptr<const FeatureFrame>& first,
                              const std::shared_ptr<const FeatureFrame>& second, const SE3& second_from_first,
                              const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
                              const std::vector<std::optional<Eigen::Vector3d>>& points, int submap) {
  const std::int64_t a = graph_.add_keyframe(first, SE3(), submap, -1).id;
  const std::int64_t b = graph_.add_keyframe(second, second_from_first, submap, a).id;
  std::vector<std::int64_t> made;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!points[i]) continue;
    const std::int64_t id = graph_.add_landmark(*points[i], a).id;
    graph_.add_observation(a, pairs[i].first, id);
    graph_.add_observation(b, pairs[i].second, id);
    graph_.describe(id);
    made.push_back(id);
  }
  adjust({b}, {a}, 2 * options_.adjust_iterations);
  const double depth = median_depth(graph_.keyframe(a));
  if (graph_.shared(a, b) < options_.init_points || !(depth > 0.0)) {
    graph_.remove_keyframe(b);
    graph_.remove_root(a);
    return false;
  }
  graph_.transform(submap, Sim3(1.0 / depth, SO3(), Eigen::Vector3d::Zero()));
  graph_.keyframe(a).unit = graph_.keyframe(b).unit = 1.0;
  for (const std::int64_t id : made) {
    if (graph_.has_landmark(id)) recent_.push_back(id);
  }
  return true;
}

void LocalMapping::initialize(const std::shared_ptr<const FeatureFrame>& frame, int submap) {
  add_depth_landmarks(graph_.add_keyframe(frame, SE3(), submap, -1).id);
}

std::shared_ptr<const DirectView> LocalMapping::process(const KeyframeInput& input) {
  const std::int64_t keyframe = input.frame->data().id;
  insert_keyframe(input);
  cull_landmarks(keyframe);
  create_landmarks(keyframe);
  auto view = direct_.add(keyframe, input.view.get());
  direct_.connect(keyframe);
  adjust_locally(keyframe);
  cull_keyframes(keyframe);
  return view;
}

void LocalMapping::insert_keyframe(const KeyframeInput& input) {
  const double scale = graph_.unit(input.reference) / input.reference_unit;
  const SE3 from_reference(input.camera_from_reference.rotation(), scale * input.camera_from_reference.translation());
  const SE3 pose = from_reference * graph_.camera_from_world(input.reference);
  std::int64_t parent = input.reference;
  const int submap = graph_.submap(input.reference);
  if (!graph_.has_keyframe(parent)) parent = graph_.keyframe_ids(submap).back();
  const std::int64_t id = graph_.add_keyframe(input.frame, pose, submap, parent).id;
  add_observations(id, input.points);
  for (const auto& [landmark, counts] : input.counts) {
    if (!graph_.has_landmark(landmark)) continue;
    graph_.landmark(landmark).visible += counts.visible;
    graph_.landmark(landmark).found += counts.found;
  }
  // The parent in the tree is the keyframe that shares most landmarks.
  const auto best = graph_.covisible(id, 1, 1);
  if (!best.empty() && best.front().id < id && graph_.submap(best.front().id) == submap)
    graph_.set_parent(id, best.front().id);
}

void LocalMapping::add_observations(std::int64_t keyframe, const std::vector<TrackedPoint>& points) {
  for (const TrackedPoint& point : points) {
    std::int64_t landmark = point.landmark;
    if (landmark < 0 && graph_.has_keyframe(point.keyframe))
      landmark = graph_.keyframe(point.keyframe).landmarks[point.keyframe_feature];
    landmark = graph_.current(landmark);
    if (landmark < 0) continue;
    graph_.add_observation(keyframe, point.feature, landmark);
    graph_.describe(landmark);
  }
}

void LocalMapping::create_landmarks(std::int64_t keyframe) {
  add_depth_landmarks(keyframe);
  triangulate_landmarks(keyframe);
  fuse_landmarks(keyframe);
}

void LocalMapping::add_depth_landmarks(std::int64_t keyframe) {
  if (graph_.sensor() == CameraKind::mono) return;
  const MapKeyframe& observer = graph_.keyframe(keyframe);
  const double far = options_.far_baselines * graph_.baseline();
  const SE3 world_from_camera = observer.camera_from_world.inverse();
  for (std::uint32_t i = 0; i < observer.frame->size(); ++i) {
    if (observer.landmarks[i] >= 0 || !std::isfinite(observer.frame->right_pixel(i))) continue;
    if (static_cast<double>(observer.frame->data().depths[i]) > far) continue;
    const std::int64_t id = graph_.add_landmark(world_from_camera * observer.frame->point(i), keyframe).id;
    graph_.add_observation(keyframe, i, id);
    graph_.describe(id);
    recent_.push_back(id);
  }
}

void LocalMapping::cull_landmarks(std::int64_t keyframe) {
  const std::size_t least = graph_.sensor() == CameraKind::mono ? 3 : 2;
  std::vector<std::int64_t> still_recent;
  for (const std::int64_t id : recent_) {
    if (!graph_.has_landmark(id)) continue;
    const MapLandmark& landmark = graph_.landmark(id);
    const std::int64_t age = keyframe - landmark.first_keyframe;
    const bool unseen = landmark.found < options_.cull_found_share * landmark.visible;
    if (unseen || (age >= 2 && landmark.observations.size() < least)) {
      graph_.remove_landmark(id);
    } else if (age < options_.cull_keyframes) {
      still_recent.push_back(id);
    }
  }
  recent_ = std::move(still_recent);
}

double LocalMapping::median_depth(const MapKeyframe& keyframe) const {
  std::vector<double> depths;
  for (const std::int64_t id : keyframe.landmarks) {
    if (id >= 0) depths.push_back((keyframe.camera_from_world * graph_.landmark(id).position).z());
  }
  return upper_median_or(std::move(depths), 0.0);
}

void LocalMapping::adjust_locally(std::int64_t keyframe) {
  std::vector<std::int64_t> free{keyframe};
  for (const Neighbor& n : graph_.covisible(keyframe, 1, static_cast<std::size_t>(options_.adjust_keyframes)))
    free.push_back(n.id);
  std::sort(free.begin(), free.end());
  std::vector<std::int64_t> fixed = fixed_observers(free);
  // The root of a submap is the origin of its world.
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (graph_.keyframe(free[i]).parent >= 0) continue;
    fixed.push_back(free[i]);
    free.erase(free.begin() + static_cast<std::ptrdiff_t>(i--));
  }
  if (fixed.empty()) {
    fixed.push_back(free.front());
    free.erase(free.begin());
  }
  adjusted_ = adjust(free, fixed, options_.adjust_iterations);
}

/// The other keyframes that observe the landmarks of `free` stay fixed: those that share most.
std::vector<std::int64_t> LocalMapping::fixed_observers(const std::vector<std::int64_t>& free) const {
  std::vector<Neighbor> others;
  for (const std::int64_t id : free) {
    for (const Neighbor& n : graph_.keyframe(id).neighbors) {
      if (std::binary_search(free.begin(), free.end(), n.id)) continue;
      const auto at = std::find_if(others.begin(), others.end(), [&](const Neighbor& o) { return o.id == n.id; });
      at == others.end() ? others.push_back(n) : void(at->shared += n.shared);
    }
  }
  std::sort(others.begin(), others.end(), [](const Neighbor& a, const Neighbor& b) {
    return a.shared != b.shared ? a.shared > b.shared : a.id < b.id;
  });
  if (others.size() > static_cast<std::size_t>(options_.adjust_fixed))
    others.resize(static_cast<std::size_t>(options_.adjust_fixed));
  std::vector<std::int64_t> fixed;
  for (const Neighbor& n : others) fixed.push_back(n.id);
  return fixed;
}

void LocalMapping::adjust_all(int submap, int iterations) {
  std::vector<std::int64_t> free, fixed;
  for (const std::int64_t id : graph_.keyframe_ids(submap))
    (graph_.keyframe(id).parent < 0 ? fixed : free).push_back(id);
  if (!free.empty()) adjust(free, fixed, iterations);
}

/// Returns the keyframes of `free` as they were and are.
std::vector<AdjustedKeyframe> LocalMapping::adjust(const std::vector<std::int64_t>& free,
                                                   const std::vector<std::int64_t>& fixed, int iterations) {
  BundleProblem problem = bundle_problem(graph_, free, fixed, options_.pixel_sigma);
  if (problem.bundle.observations.empty()) return {};
  adjust_bundle_problem(
      problem, iterations, [this] { return stop_ != nullptr && stop_->load(); }, pool_);
  std::vector<AdjustedKeyframe> adjusted;
  for (std::size_t i = 0; i < problem.keyframes.size(); ++i) {
    if (problem.bundle.fixed[i] != 0) continue;
    SE3& pose = graph_.keyframe(problem.keyframes[i]).camera_from_world;
    adjusted.push_back({problem.keyframes[i], pose.inverse(), problem.bundle.camera_from_world[i].inverse()});
    pose = problem.bundle.camera_from_world[i];
  }
  for (std::size_t i = 0; i < problem.landmarks.size(); ++i)
    graph_.landmark(problem.landmarks[i]).position = problem.bundle.points[i];
  drop_outliers(graph_, problem);
  return adjusted;
}

bool LocalMapping::is_redundant(const MapKeyframe& keyframe) const {
  const Redundancy counted = redundancy_of(graph_, keyframe, options_);
  return counted.landmarks > 0 && counted.redundant > options_.cull_seen_share * counted.landmarks;
}

void LocalMapping::cull_keyframes(std::int64_t keyframe) {
  for (const Neighbor& n : graph_.covisible(keyframe, options_.covisible_landmarks)) {
    if (!graph_.has_keyframe(n.id)) continue;
    const MapKeyframe& candidate = graph_.keyframe(n.id);
    if (candidate.parent < 0 || candidate.id + 2 > keyframe) continue;
    const bool constrained = std::any_of(
        graph_.constraints().begin(), graph_.constraints().end(),
        [&](const Constraint& constraint) { return constraint.from == candidate.id || constraint.to == candidate.id; });
    if (!constrained && is_redundant(candidate)) graph_.remove_keyframe(candidate.id);
  }
}

}  // namespace rastro
