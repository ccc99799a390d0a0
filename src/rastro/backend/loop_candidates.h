// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/math/se3.h"
#include "rastro/place/place_index.h"

namespace rastro {

struct PlaceCandidateOptions {
  double min_shared_words = 0.8;   ///< Relative to the most words that any keyframe shares: cheaper than a score.
  double min_score = 0.0;          ///< Of each keyframe alone, see lowest_similarity().
  double min_share_of_best = 0.0;  ///< Relative to the best group's sum of scores.
  int max_candidates = 5;
};

/// A keyframe that may show the same place.
struct PlaceCandidate {
  std::int64_t id = 0;
  double score = 0.0;  ///< Sum over its group.
  bool operator==(const PlaceCandidate&) const = default;
};

/// Keyframes around one, without itself.
using GroupOf = std::function<std::vector<std::int64_t>(std::int64_t)>;
using IsAllowed = std::function<bool(std::int64_t)>;

/// Place recognition (Mur-Artal et al. 2015, sections III.E and VII.A; Galvez-Lopez and Tardos 2012): keyframes similar
/// to `words`, best first, equal ones by id. `is_allowed` (if any) excludes keyframes that are connected already or too
/// recent. Scores are summed over the group of each keyframe, and the best of the group represents it: a place seen
/// from several keyframes counts more than one that looks similar by chance. Without `group_of` each keyframe is its
/// own group.
std::vector<PlaceCandidate> place_candidates(const PlaceIndex& index, const BagOfWords& words,
                                             const PlaceCandidateOptions& options, const IsAllowed& is_allowed = {},
                                             const GroupOf& group_of = {});

/// Similarity of `words` to the least similar of `neighbors`, which are in the index; 0 without any. A score alone has
/// no meaning: a keyframe that is less similar than the neighbors is no candidate.
double lowest_similarity(const PlaceIndex& index, const BagOfWords& words, std::span<const std::int64_t> neighbors);

/// Which keyframes to compare with, chosen by their position in the map and at random (the loop closure search of
/// Endres et al. 2014): without duplicates, in the order in which they were added.
class LoopCandidates {
 public:
  /// Accepts only ids from 0 to below `end`; adding others, or one twice, does nothing.
  explicit LoopCandidates(std::int64_t end) : end_(end) {}

  void add(std::int64_t id);
  /// `count` ids below `before`, descending: the most recent ones.
  void add_latest(std::int64_t before, int count);
  /// Of (distance, id) pairs the nearest `count` that are not chosen yet; equal distances by id.
  void add_nearest(std::vector<std::pair<double, std::int64_t>> near, int count);
  /// `count` of those in `from` that are not chosen yet, drawn without replacement, ascending. Deterministic for the
  /// same order of `from` and state of `random`.
  void add_random(std::vector<std::int64_t> from, int count, Random& random);

  bool is_chosen(std::int64_t id) const;
  /// All ids not chosen yet for which `is_allowed`; ascending.
  template <typename Allowed>
  std::vector<std::int64_t> free(const Allowed& is_allowed) const {
    std::vector<std::int64_t> ids;
    for (std::int64_t id = 0; id < end_; ++id) {
      if (!is_chosen(id) && is_allowed(id)) ids.push_back(id);
    }
    return ids;
  }
  const std::vector<std::int64_t>& ids() const { return ids_; }

 private:
  std::int64_t end_;
  std::vector<std::int64_t> ids_;
};

/// Distance of two poses relative to the given reach: the larger of those by position and by rotation.
double share_of_reach(const SE3& a_from_b, double reach_m, double reach_rad);

/// Nodes of a graph within `steps` edges of `id`, ascending, including itself. `for_each_neighbor(node, visit)` calls
/// visit(other) for each edge of the node.
template <typename ForEachNeighbor>
std::vector<std::int64_t> within_steps(std::int64_t id, int steps, const ForEachNeighbor& for_each_neighbor) {
  std::set<std::int64_t> found{id};
  std::vector<std::int64_t> border{id};
  for (; steps > 0 && !border.empty(); --steps) {
    std::vector<std::int64_t> beyond;
    for (const std::int64_t node : border) {
      for_each_neighbor(node, [&](std::int64_t other) {
        if (found.insert(other).second) beyond.push_back(other);
      });
    }
    border = std::move(beyond);
  }
  return {found.begin(), found.end()};
}

}  // namespace rastro
