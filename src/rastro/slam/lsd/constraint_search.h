// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/backend/rgbd/recent_items.h"
#include "rastro/base/task_pool.h"
#include "rastro/map/graph/constraint.h"
#include "rastro/place/vocabulary.h"
#include "rastro/slam/lsd/lsd_sensor.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/lsd/tracking/similarity_alignment.h"

namespace rastro {

/// Constraints of a finished keyframe with those around it and with those that look like it, by direct alignment on
/// Sim(3) in both directions (Engel et al. 2014, section 3.5).
class ConstraintSearch {
 public:
  /// All outlive this.
  ConstraintSearch(const LsdOptions& options, const LsdSensor& sensor, const SemiDenseGraph& graph, TaskPool* pool)
      : options_(options), sensor_(sensor), graph_(graph), pool_(pool) {}

  std::vector<Constraint> find(std::int64_t id, const BagOfWords& words);
  /// With keyframes of earlier visits alone, where a loop that was just closed has them: each needs the same support
  /// as that loop, which may be wrong.
  std::vector<Constraint> find_revisited(std::int64_t id);
  /// Steps from keyframe to keyframe in which nothing drifts much: farther ones are of an earlier visit.
  static constexpr int consecutive = 10;

 private:
  struct Prepared {
    Pyramid pyramid;
    AlignmentReference reference;
  };
  struct Candidate {
    std::int64_t id;
    Sim3 other_from_id;  ///< A guess.
    ConstraintKind kind = ConstraintKind::loop;
    bool is_predicted = false;  ///< By the poses of the map, which no loop moved just now.
  };
  /// What a constraint must keep.
  struct Limits {
    double inlier_share, reciprocal_error;  ///< At least; at most, squared sigmas.
  };
  std::vector<Candidate> near(std::int64_t id, const std::function<bool(std::int64_t)>& is_wanted) const;
  std::vector<Candidate> revisited(std::int64_t id, const std::vector<std::int64_t>& recent) const;
  std::vector<Constraint> align_all(const std::vector<Candidate>& candidates, std::int64_t id);
  std::shared_ptr<const Prepared> prepared(std::int64_t id);
  std::optional<Constraint> align(const Candidate& candidate, std::int64_t id);
  SimilarityAlignment align_to(const Prepared& b, const Prepared& a, const Sim3& b_from_a) const;
  bool shows_the_same(const Prepared& b, const Prepared& a, const Sim3& b_from_a) const;
  Limits limits_for(const Candidate& candidate, const Sim3& found) const;
  static bool fits(const SimilarityAlignment& alignment, double least_share);
  ConstraintKind kind_beyond(std::int64_t other, std::int64_t id) const;

  const LsdOptions& options_;
  const LsdSensor& sensor_;
  const SemiDenseGraph& graph_;
  TaskPool* pool_;
  RecentItems<Prepared> recent_{16};
};

}  // namespace rastro
