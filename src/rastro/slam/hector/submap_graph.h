// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/map/graph/constraint.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap.h"

namespace rastro {

/// A key scan matched to a submap that it is not part of.
struct ClosedLoop {
  std::size_t submap = 0, key_scan = 0;
  double score = 0.0;
  SE2 submap_from_body;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// The pose graph of submaps and key scans, with constraints from scan matching and from loop closures. Poses are in
/// the world; the matcher's own frame is called local.
class SubmapGraph {
 public:
  /// Upper bound of the error of a constraint, however uninformative a match is.
  static constexpr double largest_sigma_m = 3.0;

  SubmapGraph(const HectorOptions& options, TaskPool* pool) : options_(options), pool_(pool) {}

  std::size_t add_submap(const SE2& local_from_body);
  /// Inserts the scan into every unfinished submap and adds its constraints to them.
  std::size_t add_key_scan(KeyScan scan, const Eigen::Matrix3d& covariance);

  std::vector<std::unique_ptr<Submap>>& submaps() { return submaps_; }
  const std::vector<std::unique_ptr<Submap>>& submaps() const { return submaps_; }
  const std::vector<KeyScan>& key_scans() const { return key_scans_; }
  const std::vector<std::size_t>& key_scans_of(std::size_t submap) const { return submaps_[submap]->key_scans(); }
  const std::vector<ClosedLoop>& loops() const { return loops_; }
  /// Key scans that followed missing scans.
  const std::vector<std::size_t>& after_gaps() const { return after_gaps_; }
  /// Between key scans: from each to the next, and from the first one of a submap to one that a loop closure matched to
  /// it.
  std::vector<Constraint> constraints() const;
  SE2 world_from_key_scan(std::size_t key_scan) const { return poses_[pose_of_key_scan_[key_scan]]; }
  SE2 world_from_submap(std::size_t submap) const { return poses_[pose_of_submap_[submap]]; }
  /// The correction of the matcher's frame at the newest key scan.
  SE2 world_from_local() const;

  /// Searches for loop closures of the key scans from `first` on, see LoopSearch. Returns the number of loops closed;
  /// does not change the poses.
  int search_loops(std::size_t first);
  /// As search_loops() for all key scans, but near their poses only: adds constraints between what optimization brought
  /// together.
  int constrain_neighbors();
  void optimize();

  /// Memory of the whole graph.
  std::size_t bytes() const;
  /// From now on the search data of submaps is freed after each search.
  void search_sparingly() { sparing_ = true; }
  /// Frees the most redundant data to save memory: the cells of one submap that others overlap, else every second point
  /// of the key scans, else the cells of the oldest finished submap. Returns what was freed; empty: nothing is left to
  /// free.
  std::string give_up_redundant();

 private:
  void constrain_to_submap(std::size_t submap, std::size_t key_scan, const Eigen::Matrix3d& covariance);
  void constrain_to_last(std::size_t key_scan);
  int close(const std::vector<ClosedLoop>& loops);
  bool contradicted(const ClosedLoop& loop) const;
  bool release_submap(std::size_t step);
  bool thin_key_scans();
  Constraint edge_of(const ClosedLoop& loop) const;
  std::vector<Constraint> edges() const;
  void fit_poses();

  const HectorOptions& options_;
  TaskPool* pool_;
  std::vector<std::unique_ptr<Submap>> submaps_;
  std::vector<KeyScan> key_scans_;
  std::vector<SE2> poses_;
  std::vector<std::size_t> pose_of_submap_, pose_of_key_scan_;
  std::vector<std::size_t> after_gaps_;
  std::vector<Constraint> constraints_;  ///< Between poses_, as edge_of().
  std::vector<ClosedLoop> loops_;
  bool sparing_ = false;
};

}  // namespace rastro
