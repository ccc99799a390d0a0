// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closer.h"

#include <algorithm>
#include <map>

#include "rastro/multiview/similarity.h"
#include "rastro/slam/orb/landmark_search.h"

namespace rastro {
namespace {

std::vector<std::uint8_t> features_with_landmarks(const MapKeyframe& keyframe) {
  std::vector<std::uint8_t> use;
  for (const std::int64_t landmark : keyframe.landmarks) use.push_back(landmark >= 0 ? 1 : 0);
  return use;
}

/// Whatever shares landmarks with the keyframe or with such a one: the map knows how they lie to each other. Ascending.
std::vector<std::int64_t> connected(const MapGraph& graph, const MapKeyframe& keyframe, int least_shared) {
  std::vector<std::int64_t> ids{keyframe.id};
  for (const Neighbour& n : keyframe.neighbours) {
    ids.push_back(n.id);
    for (const Neighbour& next : graph.keyframe(n.id).neighbours) {
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

}  // namespace

LoopCloser::LoopCloser(const OrbSlamOptions& options, MapGraph& graph, PlaceMemory& places)
    : options_(options), graph_(graph), places_(places) {}

std::optional<LoopResult> LoopCloser::consider(std::int64_t id) {
  places_.update();
  if (last_closed_ >= 0 && id < last_closed_ + options_.loop_apart) return std::nullopt;
  for (const std::int64_t candidate : consistent(candidates(graph_.keyframe(id)))) {
    const auto place = verify(id, candidate);
    if (!place) continue;
    last_closed_ = id;
    groups_.clear();
    return correct_map(graph_, options_, *place);
  }
  return std::nullopt;
}

/// Of the neighbours, the one that looks least alike.
double LoopCloser::least_score(const MapKeyframe& keyframe) const {
  double least = 1.0;
  const auto neighbours = graph_.covisible(keyframe.id, options_.loop_neighbour_landmarks);
  for (const Neighbour& n : neighbours)
    least = std::min(least, similarity(*keyframe.words, *graph_.keyframe(n.id).words));
  return neighbours.empty() ? 0.0 : least;
}

/// Places that look like the keyframe's, together with their surroundings; likest first.
std::vector<std::int64_t> LoopCloser::candidates(const MapKeyframe& keyframe) const {
  const std::vector<std::int64_t> near = connected(graph_, keyframe, options_.covisible_landmarks);
  std::vector<PlaceMatch> matches =
      places_.index().find(*keyframe.words, options_.place_shared_words,
                           [&](std::int64_t id) { return !std::binary_search(near.begin(), near.end(), id); });
  const double least = least_score(keyframe);
  std::erase_if(matches, [&](const PlaceMatch& match) { return match.score < least; });
  std::map<std::int64_t, double> scores;
  for (const PlaceMatch& match : matches) scores[match.id] = match.score;
  // A place seen from several keyframes is worth more than a chance likeness of one; its best view stands for it.
  constexpr std::size_t surroundings = 10;
  constexpr double least_of_best = 0.75;
  std::map<std::int64_t, double> places;
  double best_sum = 0.0;
  for (const PlaceMatch& match : matches) {
    double sum = match.score;
    PlaceMatch likest = match;
    for (const Neighbour& n : graph_.covisible(match.id, 1, surroundings)) {
      const auto other = scores.find(n.id);
      if (other == scores.end()) continue;
      sum += other->second;
      if (other->second > likest.score) likest = {n.id, 0, other->second};
    }
    best_sum = std::max(best_sum, sum);
    double& stored = places[likest.id];
    stored = std::max(stored, sum);
  }
  std::vector<std::pair<double, std::int64_t>> ordered;
  for (const auto& [id, sum] : places) {
    if (sum >= least_of_best * best_sum) ordered.emplace_back(-sum, id);
  }
  std::sort(ordered.begin(), ordered.end());
  std::vector<std::int64_t> ids;
  for (const auto& [sum, id] : ordered) ids.push_back(id);
  if (ids.size() > static_cast<std::size_t>(options_.place_candidates))
    ids.resize(static_cast<std::size_t>(options_.place_candidates));
  return ids;
}

/// Those whose surroundings were recognised by the keyframes just before as well.
std::vector<std::int64_t> LoopCloser::consistent(const std::vector<std::int64_t>& candidates) {
  std::vector<Group> groups;
  std::vector<std::int64_t> result;
  for (const std::int64_t id : candidates) {
    Group group{{id}, 1};
    for (const Neighbour& n : graph_.covisible(id, options_.covisible_landmarks)) group.keyframes.push_back(n.id);
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

std::optional<PlaceFound> LoopCloser::verify(std::int64_t id, std::int64_t candidate) const {
  const MapKeyframe& keyframe = graph_.keyframe(id);
  const MapKeyframe& matched = graph_.keyframe(candidate);
  const MatchLimits limits{options_.place_hamming, options_.place_ratio};
  FeaturePairs features = match_by_words(*keyframe.frame, *keyframe.words, features_with_landmarks(keyframe),
                                         *matched.frame, *matched.words, features_with_landmarks(matched), limits);
  SimilarityOptions options;
  options.fix_scale = graph_.sensor() != CameraKind::mono;
  options.seed = options_.seed;
  const auto first =
      estimate_similarity(landmark_pairs(graph_, keyframe, matched, features, options_.pixel_sigma), options);
  if (!first || 2 * first->inliers < options_.loop_inliers) return std::nullopt;
  // What the words missed is looked for where the similarity expects it.
  const Sim3 matched_from_world(matched.camera_from_world);
  std::vector<std::int64_t> landmarks;
  for (const std::int64_t landmark : matched.landmarks) {
    if (landmark >= 0) landmarks.push_back(landmark);
  }
  for (const FeatureMatch& match :
       search_landmarks(graph_, landmarks, *keyframe.frame, first->first_from_second * matched_from_world,
                        options_.loop_search_px, limits)) {
    if (keyframe.landmarks[match.feature] >= 0)
      features.emplace_back(match.feature,
                            static_cast<std::uint32_t>(graph_.feature_of(candidate, landmarks[match.subject])));
  }
  std::sort(features.begin(), features.end());
  features.erase(std::unique(features.begin(), features.end()), features.end());
  const auto refined = refine_similarity(landmark_pairs(graph_, keyframe, matched, features, options_.pixel_sigma),
                                         first->first_from_second, options);
  if (!refined || refined->inliers < options_.loop_inliers) return std::nullopt;

  PlaceFound place{id, candidate, refined->first_from_second, refined->inliers, {}};
  const std::vector<std::int64_t> around = landmarks_around(graph_, candidate, options_.covisible_landmarks,
                                                            static_cast<std::size_t>(options_.local_keyframes));
  for (const FeatureMatch& match :
       search_landmarks(graph_, around, *keyframe.frame, place.keyframe_from_matched * matched_from_world,
                        options_.loop_search_px, limits))
    place.landmarks.emplace_back(match.feature, around[match.subject]);
  return static_cast<int>(place.landmarks.size()) >= options_.loop_landmarks ? std::optional(place) : std::nullopt;
}

}  // namespace rastro
