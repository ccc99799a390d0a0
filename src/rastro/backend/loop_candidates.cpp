// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/loop_candidates.h"

#include <algorithm>
#include <map>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// The score of each match plus those of its group, stored for the best of the group.
std::map<std::int64_t, double> accumulated_scores(const std::vector<PlaceMatch>& matches, const GroupOf& group_of) {
  std::map<std::int64_t, double> scores, sums;
  for (const PlaceMatch& match : matches) scores[match.id] = match.score;
  for (const PlaceMatch& match : matches) {
    double sum = match.score, best_score = match.score;
    std::int64_t best = match.id;
    for (const std::int64_t id : group_of ? group_of(match.id) : std::vector<std::int64_t>()) {
      const auto other = scores.find(id);
      if (other == scores.end()) continue;
      sum += other->second;
      if (other->second <= best_score) continue;
      best = id;
      best_score = other->second;
    }
    double& stored = sums[best];
    stored = std::max(stored, sum);
  }
  return sums;
}

}  // namespace

std::vector<PlaceCandidate> place_candidates(const PlaceIndex& index, const BagOfWords& words,
                                             const PlaceCandidateOptions& options, const IsAllowed& is_allowed,
                                             const GroupOf& group_of) {
  std::vector<PlaceMatch> matches = index.find(words, options.min_shared_words, is_allowed);
  std::erase_if(matches, [&](const PlaceMatch& match) { return match.score < options.min_score; });
  const std::map<std::int64_t, double> sums = accumulated_scores(matches, group_of);
  double best_sum = 0.0;
  for (const auto& [id, sum] : sums) best_sum = std::max(best_sum, sum);
  std::vector<PlaceCandidate> candidates;
  for (const auto& [id, sum] : sums) {
    if (sum >= options.min_share_of_best * best_sum) candidates.push_back({id, sum});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const PlaceCandidate& a, const PlaceCandidate& b) { return a.score > b.score; });
  const auto most = static_cast<std::size_t>(std::max(0, options.max_candidates));
  if (candidates.size() > most) candidates.resize(most);
  return candidates;
}

double lowest_similarity(const PlaceIndex& index, const BagOfWords& words, std::span<const std::int64_t> neighbors) {
  double least = 1.0;
  for (const std::int64_t id : neighbors) {
    const BagOfWords* theirs = index.find_words(id);
    RASTRO_CHECK(theirs != nullptr, "the neighbors are in the index");
    least = std::min(least, similarity(words, *theirs));
  }
  return neighbors.empty() ? 0.0 : least;
}

bool LoopCandidates::is_chosen(std::int64_t id) const { return std::find(ids_.begin(), ids_.end(), id) != ids_.end(); }

void LoopCandidates::add(std::int64_t id) {
  if (id >= 0 && id < end_ && !is_chosen(id)) ids_.push_back(id);
}

void LoopCandidates::add_latest(std::int64_t before, int count) {
  for (std::int64_t k = 1; k <= count; ++k) add(before - k);
}

void LoopCandidates::add_nearest(std::vector<std::pair<double, std::int64_t>> near, int count) {
  std::erase_if(near, [&](const auto& one) { return one.second < 0 || one.second >= end_ || is_chosen(one.second); });
  std::sort(near.begin(), near.end());
  for (std::size_t k = 0; k < near.size() && k < static_cast<std::size_t>(std::max(0, count)); ++k) add(near[k].second);
}

void LoopCandidates::add_random(std::vector<std::int64_t> from, int count, Random& random) {
  std::erase_if(from, [&](std::int64_t id) { return id < 0 || id >= end_ || is_chosen(id); });
  const auto most = std::min(from.size(), static_cast<std::size_t>(std::max(0, count)));
  for (std::size_t i = 0; i < most; ++i)
    std::swap(from[i], from[i + random.below(static_cast<std::uint32_t>(from.size() - i))]);
  from.resize(most);
  std::sort(from.begin(), from.end());
  for (const std::int64_t id : from) add(id);
}

double share_of_reach(const SE3& a_from_b, double reach_m, double reach_rad) {
  return std::max(a_from_b.translation().norm() / reach_m, a_from_b.rotation().log().norm() / reach_rad);
}

}  // namespace rastro
