// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closing/loop_closing.h"

#include <algorithm>
#include <utility>

#include "rastro/backend/loop_candidates.h"
#include "rastro/slam/orb/map/landmark_search.h"

namespace rastro {
namespace {

/// Keyframes that share landmarks with the keyframe or with its covisible ones: their relative poses are known already.
/// Ascending.
std::vector<std::int64_t> connected(const MapGraph& graph, const MapKeyframe& keyframe, int least_shared) {
  std::vector<std::int64_t> ids{keyframe.id};
  for (const Neighbor& n : keyframe.neighbors) {
    ids.push_back(n.id);
    for (const Neighbor& next : graph.keyframe(n.id).neighbors) {
      if (next.shared >= least_shared) ids.push_back(next.id);
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

using FeaturePairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Landmarks of both keyframes whose features match.
std::vector<SimilarityPair> landmark_pairs(const MapGraph& graph, const MapKeyframe& first, const MapKeyframe& second,
                                           const FeaturePairs& features, double pixel_sigma) {
  std::vector<SimilarityPair> pairs;
  for (const auto& [a, b] : features) {
    SimilarityPair pair;
    pair.first_point = first.camera_from_world * graph.landmark(first.landmarks[a]).position;
    pair.second_point = second.camera_from_world * graph.landmark(second.landmarks[b]).position;
    pair.first_ray = first.frame->ray(a);
    pair.second_ray = second.frame->ray(b);
    pair.first_sigma = pixel_sigma * graph.sigma(*first.frame, a);
    pair.second_sigma = pixel_sigma * graph.sigma(*second.frame, b);
    pairs.push_back(pair);
  }
  return pairs;
}

std::vector<std::int64_t> ids_of(const std::vector<Neighbor>& neighbors) {
  std::vector<std::int64_t> ids;
  ids.reserve(neighbors.size());
  for (const Neighbor& n : neighbors) ids.push_back(n.id);
  return ids;
}

/// A recognized keyframe and its neighbors; ascending.
std::vector<std::int64_t> surroundings_of(const MapGraph& graph, std::int64_t id, int least_shared) {
  std::vector<std::int64_t> ids = ids_of(graph.covisible(id, least_shared));
  ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

/// Length of the path through the keyframes of a submap from one to a later one. A rotation counts like a step of as
/// many units, since tracking drifts in it too.
double path_between(const MapGraph& graph, std::int64_t from, std::int64_t to) {
  double path = 0.0;
  SE3 previous = graph.keyframe(from).camera_from_world;
  for (const std::int64_t id : graph.keyframe_ids(graph.keyframe(from).submap)) {
    if (id <= from || id > to) continue;
    const SE3& pose = graph.keyframe(id).camera_from_world;
    const SE3 step = previous * pose.inverse();
    path += step.translation().norm() + step.rotation().log().norm();
    previous = pose;
  }
  return path;
}

/// How far a loop is from the relative pose in the map, in standard deviations of the drift along the path between.
double drift_sigmas(const MapGraph& graph, const VerifiedLoop& loop, const OdometryDrift& drift) {
  const MapKeyframe &keyframe = graph.keyframe(loop.keyframe), &matched = graph.keyframe(loop.matched);
  if (keyframe.submap != matched.submap) return 0.0;
  const double path = path_between(graph, std::min(loop.matched, loop.keyframe), std::max(loop.matched, loop.keyframe));
  const SE3 predicted = keyframe.camera_from_world * matched.camera_from_world.inverse();
  const SE3 measured(loop.keyframe_from_matched.rotation(), loop.keyframe_from_matched.translation());
  return graph_sigmas(predicted, measured, drift.covariance(path));
}

/// Landmarks that are where the similarity predicts them. A similarity that is half right finds landmarks in its search
/// windows, but aside of their predicted positions.
int count_fitting(const MapGraph& graph, const MapKeyframe& keyframe, const VerifiedLoop& loop,
                  const Sim3& keyframe_from_world, double pixel_sigma) {
  constexpr double chi2_95 = 5.991;
  const auto fits = [&](const std::pair<std::uint32_t, std::int64_t>& match) {
    const Eigen::Vector3d predicted = keyframe_from_world * graph.landmark(match.second).position;
    const double sigma = pixel_sigma * graph.sigma(*keyframe.frame, match.first);
    return predicted.z() > 0.0 &&
           (predicted.hnormalized() - keyframe.frame->ray(match.first)).squaredNorm() <= chi2_95 * sigma * sigma;
  };
  return static_cast<int>(std::count_if(loop.landmarks.begin(), loop.landmarks.end(), fits));
}

AcceptanceOptions loop_acceptance(const OrbSlamOptions& options) {
  return {.min_inliers = options.loop_inliers,
          .min_observed = options.loop_landmarks,
          .min_chance_ratio = options.loop_chance_ratio,
          .min_observed_share = options.loop_fit_share,
          .max_graph_sigmas = options.loop_max_sigmas,
          .min_confirmations = options.loop_consistent};
}

}  // namespace

LoopClosing::LoopClosing(const OrbSlamOptions& options, MapGraph& graph, KeyframeDatabase& database)
    : options_(options), graph_(graph), database_(database), acceptance_(loop_acceptance(options)) {}

std::optional<LoopResult> LoopClosing::process(std::int64_t id) {
  database_.update();
  if (last_closed_ >= 0 && id < last_closed_ + options_.loop_min_gap) return std::nullopt;
  const MapKeyframe& keyframe = graph_.keyframe(id);
  for (const Hypothesis& hypothesis : acceptance_.next(detect_candidates(keyframe))) {
    if (!hypothesis.confirmed) continue;
    const auto loop = verify(keyframe, graph_.keyframe(hypothesis.place));
    if (!loop || acceptance_.judged(hypothesis, loop->evidence()).state() != HypothesisState::accepted) continue;
    last_closed_ = id;
    acceptance_.clear();
    return correct_loop(graph_, options_, *loop);
  }
  return std::nullopt;
}

/// Keyframes that are similar to this one, together with their surroundings, and at least as similar as its least
/// similar neighbor; excludes those connected to it. Best first.
std::vector<Hypothesis> LoopClosing::detect_candidates(const MapKeyframe& keyframe) const {
  constexpr double min_share_of_best = 0.75;
  constexpr std::size_t surroundings = 10;
  const PlaceIndex& index = database_.index();
  const auto neighbors = ids_of(graph_.covisible(keyframe.id, options_.loop_neighbor_landmarks));
  const auto near = connected(graph_, keyframe, options_.covisible_landmarks);
  const PlaceCandidateOptions options{options_.place_shared_words, lowest_similarity(index, *keyframe.words, neighbors),
                                      min_share_of_best, options_.place_candidates};
  const auto is_disconnected = [&](std::int64_t id) { return !std::binary_search(near.begin(), near.end(), id); };
  const auto group_of = [&](std::int64_t id) { return ids_of(graph_.covisible(id, 1, surroundings)); };
  std::vector<Hypothesis> hypotheses;
  for (const PlaceCandidate& candidate : place_candidates(index, *keyframe.words, options, is_disconnected, group_of))
    hypotheses.push_back({candidate.id, surroundings_of(graph_, candidate.id, options_.covisible_landmarks)});
  return hypotheses;
}

/// Estimates a similarity from pairs of landmarks, and finds the landmarks of the candidate where it predicts them.
std::optional<VerifiedLoop> LoopClosing::verify(const MapKeyframe& keyframe, const MapKeyframe& candidate) const {
  const auto similarity = find_similarity(keyframe, candidate);
  if (!similarity) return std::nullopt;
  VerifiedLoop loop{keyframe.id, candidate.id, similarity->first_from_second, similarity->inliers, {}};
  const std::vector<std::int64_t> around = landmarks_around(graph_, candidate.id, options_.covisible_landmarks,
                                                            static_cast<std::size_t>(options_.local_keyframes));
  const Sim3 keyframe_from_world = loop.keyframe_from_matched * Sim3(candidate.camera_from_world);
  const LandmarkSearchOptions search{.radius_px = options_.loop_search_px, .limits = limits()};
  for (const FeatureMatch& match : search_landmarks(graph_, around, *keyframe.frame, keyframe_from_world, search))
    loop.landmarks.emplace_back(match.feature, around[match.subject]);
  loop.fitting = count_fitting(graph_, keyframe, loop, keyframe_from_world, options_.pixel_sigma);
  const auto wrong = rotations_beyond_windows(options_.loop_search_px * graph_.level_scales().back(), graph_.camera());
  for (const SO3& rotation : wrong) {
    const Sim3 elsewhere = Sim3(1.0, rotation, Eigen::Vector3d::Zero()) * keyframe_from_world;
    loop.chance_landmarks +=
        static_cast<double>(search_landmarks(graph_, around, *keyframe.frame, elsewhere, search).size()) /
        static_cast<double>(wrong.size());
  }
  loop.graph_sigmas = drift_sigmas(graph_, loop, {options_.loop_drift_share, options_.loop_drift_rad_per_m});
  return loop;
}

/// From matches by words, then with those added by guided search if half of the required inliers are found.
std::optional<SimilarityFit> LoopClosing::find_similarity(const MapKeyframe& keyframe,
                                                          const MapKeyframe& candidate) const {
  SimilarityOptions options;
  options.fix_scale = graph_.sensor() != CameraKind::mono;
  options.seed = options_.seed;
  const auto use = features_with_landmarks(keyframe), use_of_candidate = features_with_landmarks(candidate);
  FeaturePairs features =
      match_by_words(worded_features(*keyframe.frame, *keyframe.words, use),
                     worded_features(*candidate.frame, *candidate.words, use_of_candidate), limits());
  const auto first =
      estimate_similarity(landmark_pairs(graph_, keyframe, candidate, features, options_.pixel_sigma), options);
  if (!first || 2 * first->inliers < options_.loop_inliers) return std::nullopt;
  const std::vector<std::int64_t> landmarks = landmarks_of(candidate);
  for (const FeatureMatch& match : search_landmarks(graph_, landmarks, *keyframe.frame,
                                                    first->first_from_second * Sim3(candidate.camera_from_world),
                                                    {.radius_px = options_.loop_search_px, .limits = limits()})) {
    if (keyframe.landmarks[match.feature] >= 0)
      features.emplace_back(match.feature,
                            static_cast<std::uint32_t>(graph_.feature_of(candidate.id, landmarks[match.subject])));
  }
  std::sort(features.begin(), features.end());
  features.erase(std::unique(features.begin(), features.end()), features.end());
  return refine_similarity(landmark_pairs(graph_, keyframe, candidate, features, options_.pixel_sigma),
                           first->first_from_second, options);
}

}  // namespace rastro
