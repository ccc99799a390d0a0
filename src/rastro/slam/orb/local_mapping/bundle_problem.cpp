// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/bundle_problem.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

namespace rastro {
namespace {

bool is_outlier(const BundleObservation& observation, double squared_error) {
  return squared_error > (std::isfinite(observation.right_x) ? 7.815 : 5.991);
}

void take_out(BundleProblem& problem, const std::vector<double>& squared_errors) {
  std::vector<BundleObservation> kept;
  std::vector<BundleProblem::Seen> kept_seen;
  for (std::size_t i = 0; i < problem.seen.size(); ++i) {
    if (is_outlier(problem.bundle.observations[i], squared_errors[i])) {
      problem.outliers.push_back(problem.seen[i]);
    } else {
      kept.push_back(problem.bundle.observations[i]);
      kept_seen.push_back(problem.seen[i]);
    }
  }
  problem.bundle.observations = std::move(kept);
  problem.seen = std::move(kept_seen);
}

using CameraOfKeyframe = std::pair<std::int64_t, std::uint32_t>;

/// Adds a point and its observations by the cameras (ascending by keyframe).
void add_observed_point(const MapGraph& graph, const MapLandmark& landmark,
                        const std::vector<CameraOfKeyframe>& cameras, double pixel_sigma, BundleProblem& problem) {
  const auto point = static_cast<std::uint32_t>(problem.bundle.points.size());
  problem.bundle.points.push_back(landmark.position);
  for (const LandmarkObservation& o : landmark.observations) {
    const auto at = std::lower_bound(cameras.begin(), cameras.end(), CameraOfKeyframe{o.keyframe, 0});
    if (at == cameras.end() || at->first != o.keyframe) continue;
    const FeatureFrame& frame = *graph.keyframe(o.keyframe).frame;
    problem.bundle.observations.push_back({at->second, point, frame.ray(o.feature), frame.right_ray(o.feature),
                                           pixel_sigma * graph.sigma(frame, o.feature)});
    problem.seen.emplace_back(o.keyframe, landmark.id);
  }
}

/// Those between two of the cameras (ascending by keyframe).
void add_direct_poses(const MapGraph& graph, const std::vector<CameraOfKeyframe>& cameras, BundleProblem& problem) {
  const auto camera_of = [&](std::int64_t keyframe) -> std::optional<std::uint32_t> {
    const auto at = std::lower_bound(cameras.begin(), cameras.end(), CameraOfKeyframe{keyframe, 0});
    if (at == cameras.end() || at->first != keyframe) return std::nullopt;
    return at->second;
  };
  for (const DirectPose& direct : graph.direct_poses()) {
    const auto from = camera_of(direct.keyframe), to = camera_of(direct.camera);
    if (!from || !to || (problem.bundle.fixed[*from] != 0 && problem.bundle.fixed[*to] != 0)) continue;
    problem.bundle.relative_poses.push_back(
        {*from, *to, direct.pose.camera_from_keyframe, direct.pose.covariance.inverse()});
  }
}

}  // namespace

BundleProblem bundle_problem(const MapGraph& graph, const std::vector<std::int64_t>& free,
                             const std::vector<std::int64_t>& fixed, double pixel_sigma) {
  BundleProblem problem;
  problem.bundle.baseline = graph.baseline();
  std::vector<CameraOfKeyframe> cameras;
  for (const auto* list : {&free, &fixed}) {
    for (const std::int64_t id : *list) {
      cameras.emplace_back(id, static_cast<std::uint32_t>(problem.keyframes.size()));
      problem.keyframes.push_back(id);
      problem.bundle.camera_from_world.push_back(graph.keyframe(id).camera_from_world);
      problem.bundle.fixed.push_back(list == &fixed ? 1 : 0);
    }
  }
  std::sort(cameras.begin(), cameras.end());
  for (const std::int64_t id : free) {
    for (const std::int64_t landmark : graph.keyframe(id).landmarks) {
      if (landmark >= 0) problem.landmarks.push_back(landmark);
    }
  }
  std::sort(problem.landmarks.begin(), problem.landmarks.end());
  problem.landmarks.erase(std::unique(problem.landmarks.begin(), problem.landmarks.end()), problem.landmarks.end());
  for (const std::int64_t id : problem.landmarks)
    add_observed_point(graph, graph.landmark(id), cameras, pixel_sigma, problem);
  add_direct_poses(graph, cameras, problem);
  return problem;
}

void adjust_bundle_problem(BundleProblem& problem, int iterations, const std::function<bool()>& stopped,
                           TaskPool* pool) {
  BundleOptions options;
  options.iterations = (iterations + 1) / 2;
  options.stopped = stopped;
  for (int round = 0; round < 2; ++round) {
    const BundleResult result = adjust_bundle(problem.bundle, options, pool);
    if (stopped && stopped()) return;  // an outlier may have become an inlier
    take_out(problem, result.squared_errors);
    options.iterations = iterations;
  }
}

void drop_outliers(MapGraph& graph, const BundleProblem& problem) {
  for (const auto& [keyframe, landmark] : problem.outliers) {
    if (graph.has_keyframe(keyframe) && graph.has_landmark(landmark)) graph.remove_observation(keyframe, landmark);
  }
  const std::size_t least = graph.sensor() == CameraKind::mono ? 2 : 1;
  for (const std::int64_t id : problem.landmarks) {
    if (!graph.has_landmark(id)) continue;
    if (graph.landmark(id).observations.size() < least) {
      graph.remove_landmark(id);
    } else {
      graph.describe(id);
    }
  }
}

}  // namespace rastro
