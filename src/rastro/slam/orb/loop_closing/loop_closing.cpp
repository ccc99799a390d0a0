// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closing/loop_closing.h"

#include <algorithm>
#include <map>

#include "rastro/slam/orb/map/landmark_search.h"

namespace rastro {
namespace {

/// Whatever shares landmarks with the keyframe or with such a one: the map knows how they lie to each other. Ascending.
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

bool share_one(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  auto i = a.begin(), j = b.begin();
  while (i != a.end() && j != b.end()) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

using FeaturePairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Landmarks of both keyframes that features say are the same.
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

/// Of each candidate the sum of its score and of those around it, and the best of them that stands for it: a place
/// seen from several keyframes is worth more than a chance likeness of one.
std::map<std::int64_t, double> accumulated_scores(const MapGraph& graph, const std::vector<PlaceMatch>& matches) {
  constexpr std::size_t surroundings = 10;
  std::map<std::int64_t, double> scores, sums;
  for (const PlaceMatch& match : matches) scores[match.id] = match.score;
  for (const PlaceMatch& match : matches) {
    double sum = match.score, best_score = match.score;
    std::int64_t best = match.id;
    for (const Neighbor& n : graph.covisible(match.id, 1, surroundings)) {
      const auto other = scores.find(n.id);
      if (other == scores.end()) continue;
      sum += other->second;
      if (other->second <= best_score) continue;
      best = n.id;
      best_score = other->second;
    }
    double& stored = sums[best];
    stored = std::max(stored, sum);
  }
  return sums;
}

}  // namespace

LoopClosing::LoopClosing(const OrbSlamOptions& options, MapGraph& graph, KeyframeDatabase& database)
    : options_(options), graph_(graph), database_(database) {}

std::optional<LoopResult> LoopClosing::process(std::int64_t id) {
  database_.update();
  if (last_closed_ >= 0 && id < last_closed_ + options_.loop_apart) return std::nullopt;
  const MapKeyframe& keyframe = graph_.keyframe(id);
  for (const std::int64_t candidate : consistent(detect_candidates(keyframe))) {
    const auto loop = verify(keyframe, graph_.keyframe(candidate));
    if (!loop) continue;
    last_closed_ = id;
    groups_.clear();
    return correct_loop(graph_, options_, *loop);
  }
  return std::nullopt;
}

/// Keyframes that look like this one, together with their surroundings; best first.
std::vector<std::int64_t> LoopClosing::detect_candidates(const MapKeyframe& keyframe) const {
  constexpr double min_share_of_best = 0.75;
  const std::map<std::int64_t, double> sums = accumulated_scores(graph_, similar_keyframes(keyframe));
  double best_sum = 0.0;
  for (const auto& [id, sum] : sums) best_sum = std::max(best_sum, sum);
  std::vector<std::pair<double, std::int64_t>> ordered;
  for (const auto& [id, sum] : sums) {
    if (sum >= min_share_of_best * best_sum) ordered.emplace_back(-sum, id);
  }
  std::sort(ordered.begin(), ordered.end());
  std::vector<std::int64_t> ids;
  for (const auto& [sum, id] : ordered) ids.push_back(id);
  if (ids.size() > static_cast<std::size_t>(options_.place_candidates))
    ids.resize(static_cast<std::size_t>(options_.place_candidates));
  return ids;
}

/// At least as similar as the least similar neighbor, and not connected to the keyframe.
std::vector<PlaceMatch> LoopClosing::similar_keyframes(const MapKeyframe& keyframe) const {
  const std::vector<std::int64_t> near = connected(graph_, keyframe, options_.covisible_landmarks);
  std::vector<PlaceMatch> matches =
      database_.index().find(*keyframe.words, options_.place_shared_words,
                             [&](std::int64_t id) { return !std::binary_search(near.begin(), near.end(), id); });
  const double least = min_score(keyframe);
  std::erase_if(matches, [&](const PlaceMatch& match) { return match.score < least; });
  return matches;
}

/// Of the neighbors, the one that looks least alike.
double LoopClosing::min_score(const MapKeyframe& keyframe) const {
  double least = 1.0;
  const auto neighbors = graph_.covisible(keyframe.id, options_.loop_neighbour_landmarks);
  for (const Neighbor& n : neighbors)
    least = std::min(least, similarity(*keyframe.words, *graph_.keyframe(n.id).words));
  return neighbors.empty() ? 0.0 : least;
}

/// Those whose surroundings were recognized by the keyframes just before as well.
std::vector<std::int64_t> LoopClosing::consistent(const std::vector<std::int64_t>& candidates) {
  std::vector<Group> groups;
  std::vector<std::int64_t> result;
  for (const std::int64_t id : candidates) {
    Group group{{id}, 1};
    for (const Neighbor& n : graph_.covisible(id, options_.covisible_landmarks)) group.keyframes.push_back(n.id);
    std::sort(group.keyframes.begin(), group.keyframes.end());
    for (const Group& before : groups_) {
      if (share_one(before.keyframes, group.keyframes)) group.times = std::max(group.times, before.times + 1);
    }
    if (group.times >= options_.loop_consistent) result.push_back(id);
    groups.push_back(std::move(group));
  }
  groups_ = std::move(groups);
  return result;
}

/// A similarity that enough pairs of landmarks fit, and enough landmarks of the place found where it predicts them.
std::optional<VerifiedLoop> LoopClosing::verify(const MapKeyframe& keyframe, const MapKeyframe& candidate) const {
  const auto similarity = find_similarity(keyframe, candidate);
  if (!similarity) return std::nullopt;
  VerifiedLoop loop{keyframe.id, candidate.id, similarity->first_from_second, similarity->inliers, {}};
  const std::vector<std::int64_t> around = landmarks_around(graph_, candidate.id, options_.covisible_landmarks,
                                                            static_cast<std::size_t>(options_.local_keyframes));
  for (const FeatureMatch& match :
       search_landmarks(graph_, around, *keyframe.frame, loop.keyframe_from_matched * Sim3(candidate.camera_from_world),
                        {.radius_px = options_.loop_search_px, .limits = limits()}))
    loop.landmarks.emplace_back(match.feature, around[match.subject]);
  return static_cast<int>(loop.landmarks.size()) >= options_.loop_landmarks ? std::optional(loop) : std::nullopt;
}

/// From matches by words, then from those that guided search adds.
std::optional<SimilarityFit> LoopClosing::find_similarity(const MapKeyframe& keyframe,
                                                          const MapKeyframe& candidate) const {
  SimilarityOptions options;
  options.fix_scale = graph_.sensor() != CameraKind::mono;
  options.seed = options_.seed;
  FeaturePairs features =
      match_by_words(*keyframe.frame, *keyframe.words, features_with_landmarks(keyframe), *candidate.frame,
                     *candidate.words, features_with_landmarks(candidate), limits());
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
  auto refined = refine_similarity(landmark_pairs(graph_, keyframe, candidate, features, options_.pixel_sigma),
                                   first->first_from_second, options);
  return refined && refined->inliers >= options_.loop_inliers ? std::move(refined) : std::nullopt;
}

}  // namespace rastro
