// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap_graph.h"

namespace rastro {

/// Finds loop closures of the key scans of a graph in its old submaps: which of these may show the same place and how
/// far away, the match with each, and whether it is to be believed. Does not change the graph.
class LoopSearch {
 public:
  LoopSearch(const SubmapGraph& graph, const HectorOptions& options, TaskPool* pool)
      : graph_(graph), submaps_(graph.submaps()), key_scans_(graph.key_scans()), options_(options), pool_(pool) {}

  /// Of the key scans from this one on, in finished submaps near their predicted poses.
  std::vector<ClosedLoop> from(std::size_t first) const;
  /// Of all key scans, but near their poses only: what optimization brought together.
  std::vector<ClosedLoop> of_neighbors() const;

 private:
  struct Candidate {
    std::size_t submap, key_scan;
    double reach_m, reach_rad;
    bool search;  ///< False: only refined from the pose in the graph.
  };

  std::vector<ClosedLoop> found_in(const std::vector<Candidate>& candidates) const;
  std::vector<Candidate> candidates_of(std::size_t key_scan, bool near_only) const;
  bool made_by(std::size_t submap, std::size_t key_scan) const;
  double distance_to(std::size_t submap, const Eigen::Vector2d& world) const;
  std::vector<std::size_t> last_constrained() const;
  Eigen::Vector2d gap_sigma(std::size_t from, std::size_t to) const;
  void prepare_search(const std::vector<Candidate>& candidates) const;
  std::vector<std::optional<ClosedLoop>> verified(const std::vector<Candidate>& candidates) const;
  std::optional<ClosedLoop> verify(const Candidate& candidate) const;
  std::vector<Eigen::Vector2d> points_around(std::size_t key_scan) const;
  std::optional<Eigen::Vector2d> unseen_direction(const Candidate& candidate, const SE2& submap_from_body) const;
  SE2 correction_by(const ClosedLoop& loop) const;
  std::vector<ClosedLoop> accepted(const std::vector<std::optional<ClosedLoop>>& verified) const;

  const SubmapGraph& graph_;
  const std::vector<std::unique_ptr<Submap>>& submaps_;  ///< Those of the graph, as are the key scans.
  const std::vector<KeyScan>& key_scans_;
  const HectorOptions& options_;
  TaskPool* pool_;
};

}  // namespace rastro
