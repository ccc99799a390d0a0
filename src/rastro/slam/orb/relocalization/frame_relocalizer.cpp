// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/relocalization/frame_relocalizer.h"

#include <algorithm>

#include "rastro/backend/loop_candidates.h"
#include "rastro/multiview/absolute_pose.h"
#include "rastro/optimize/pose_refinement.h"
#include "rastro/slam/orb/map/landmark_search.h"

namespace rastro {
namespace {

/// Refines the pose from features matched to landmarks.
PoseRefinement refined(const MapGraph& graph, const FeatureFrame& frame,
                       const std::vector<std::pair<std::uint32_t, std::int64_t>>& seen, const SE3& start,
                       double pixel_sigma) {
  std::vector<PoseObservation> observations;
  for (const auto& [feature, landmark] : seen)
    observations.push_back({graph.landmark(landmark).position, frame.ray(feature), frame.right_ray(feature),
                            pixel_sigma * graph.sigma(frame, feature)});
  PoseRefinementOptions options;
  options.baseline = graph.baseline();
  return refine_pose(start, observations, options);
}

}  // namespace

FrameRelocalizer::FrameRelocalizer(const OrbSlamOptions& options, const MapGraph& graph, KeyframeDatabase& database)
    : options_(options), graph_(graph), database_(database) {}

std::optional<Relocation> FrameRelocalizer::find(const FeatureFrame& frame, int min_inliers,
                                                 const std::vector<std::int64_t>& first) {
  database_.update();
  const BagOfWords words = database_.words_of(frame);
  std::vector<std::int64_t> candidates = first;
  for (const PlaceCandidate& candidate :
       place_candidates(database_.index(), words,
                        {.min_shared_words = options_.place_shared_words, .max_candidates = options_.place_candidates}))
    candidates.push_back(candidate.id);
  for (const std::int64_t id : candidates) {
    const auto found = try_keyframe(frame, words, id);
    if (found && found->inliers >= min_inliers) return found;
  }
  return std::nullopt;
}

std::optional<Relocation> FrameRelocalizer::try_keyframe(const FeatureFrame& frame, const BagOfWords& words,
                                                         std::int64_t id) const {
  const auto pose = pose_by_words(frame, words, graph_.keyframe(id));
  if (!pose) return std::nullopt;
  // From the pose of a few matches to all landmarks that should be visible, in smaller windows each time.
  Relocation found{id, *pose, 0};
  const std::vector<std::int64_t> around =
      landmarks_around(graph_, id, options_.covisible_landmarks, static_cast<std::size_t>(options_.local_keyframes));
  for (const double radius : {options_.relocalize_search_px, options_.local_search_px}) {
    std::vector<std::pair<std::uint32_t, std::int64_t>> seen;
    for (const FeatureMatch& match :
         search_landmarks(graph_, around, frame, Sim3(found.camera_from_world),
                          {.radius_px = radius, .limits = {options_.match_hamming, options_.match_ratio}}))
      seen.emplace_back(match.feature, around[match.subject]);
    const PoseRefinement result = refined(graph_, frame, seen, found.camera_from_world, options_.pixel_sigma);
    found.camera_from_world = result.camera_from_world;
    found.inliers = result.inliers;
  }
  return found;
}

/// PnP with the landmarks matched by words.
std::optional<SE3> FrameRelocalizer::pose_by_words(const FeatureFrame& frame, const BagOfWords& words,
                                                   const MapKeyframe& keyframe) const {
  const auto use = features_with_landmarks(keyframe);
  const auto pairs =
      match_by_words(worded_features(frame, words, {}), worded_features(*keyframe.frame, *keyframe.words, use),
                     {.max_distance = options_.place_hamming, .max_ratio = options_.place_ratio});
  if (static_cast<int>(pairs.size()) < options_.relocalize_matches) return std::nullopt;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (const auto& [feature, other] : pairs) {
    points.push_back(graph_.landmark(keyframe.landmarks[other]).position);
    rays.push_back(frame.ray(feature));
  }
  AbsolutePoseOptions options;
  options.focal_px = graph_.camera().fx;
  options.max_iterations = options_.pnp_iterations;
  constexpr double coarse_features_px = 4.0;
  options.max_error_px = coarse_features_px;
  options.seed = options_.seed;
  const auto pose = estimate_absolute_pose(points, rays, options);
  constexpr int min_inliers = 6;
  if (!pose || pose->inliers < min_inliers) return std::nullopt;
  return pose->camera_from_world;
}

}  // namespace rastro
