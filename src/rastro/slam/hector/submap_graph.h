// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/map/graph/constraint.h"
#include "rastro/optimize/planar_pose_graph.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap.h"

namespace rastro {

/// A key scan found again in a submap that it did not make.
struct ClosedLoop {
  std::size_t submap = 0, key_scan = 0;
  double score = 0.0;
  SE2 submap_from_body;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Submaps and key scans, tied together by what the matcher found and by loops: what scan matching alone lacks. Poses
/// are of the world; the matcher's own frame is called local.
class SubmapGraph {
 public:
  SubmapGraph(const HectorOptions& options, TaskPool* pool) : options_(options), pool_(pool) {}

  std::size_t add_submap(const SE2& local_from_body);
  /// Puts the scan into every unfinished submap and ties it to them.
  std::size_t add_key_scan(KeyScan scan, const Eigen::Matrix3d& covariance);

  std::vector<std::unique_ptr<Submap>>& submaps() { return submaps_; }
  const std::vector<KeyScan>& key_scans() const { return key_scans_; }
  const std::vector<std::size_t>& key_scans_of(std::size_t submap) const { return submaps_[submap]->key_scans(); }
  const std::vector<ClosedLoop>& loops() const { return loops_; }
  /// Between key scans: from each to the next, and from the first one of a submap to one found again in it.
  std::vector<Constraint> constraints() const;
  SE2 world_from_key_scan(std::size_t key_scan) const { return poses_[pose_of_key_scan_[key_scan]]; }
  SE2 world_from_submap(std::size_t submap) const { return poses_[pose_of_submap_[submap]]; }
  /// Where the newest key scan puts the matcher's frame.
  SE2 world_from_local() const;

  /// Looks for the key scans from `first` on in the finished submaps near where they should be. Returns how many loops
  /// were closed; the poses are not touched.
  int look_for_loops(std::size_t first);
  /// As look_for_loops() for all key scans, near their poses only: ties what the optimised poses brought together.
  int tie_neighbours();
  void optimize();

 private:
  struct Candidate {
    std::size_t submap, key_scan;
    double reach_m, reach_rad;
    bool search;  ///< False: only refined from where the graph puts it.
  };

  void tie(std::size_t submap, std::size_t key_scan, const Eigen::Matrix3d& covariance);
  void tie_to_last(std::size_t key_scan);
  std::vector<double> untied_paths(const KeyScan& scan) const;
  std::vector<Candidate> candidates_of(std::size_t key_scan, bool near_only) const;
  bool made_by(std::size_t submap, std::size_t key_scan) const;
  double distance_to(std::size_t submap, const Eigen::Vector2d& world) const;
  std::vector<Eigen::Vector2d> points_around(std::size_t key_scan) const;
  std::optional<ClosedLoop> try_candidate(const Candidate& candidate) const;
  SE2 correction_by(const ClosedLoop& loop) const;
  std::vector<ClosedLoop> confirmed(const std::vector<std::optional<ClosedLoop>>& found) const;
  int close(const std::vector<Candidate>& candidates);
  bool contradicted(const ClosedLoop& loop) const;
  PlanarEdge edge_of(const ClosedLoop& loop) const;
  std::vector<PlanarEdge> edges() const;

  const HectorOptions& options_;
  TaskPool* pool_;
  std::vector<std::unique_ptr<Submap>> submaps_;
  std::vector<KeyScan> key_scans_;
  std::vector<SE2> poses_;
  std::vector<std::size_t> pose_of_submap_, pose_of_key_scan_;
  std::vector<PlanarEdge> ties_;
  std::vector<ClosedLoop> loops_;
};

}  // namespace rastro
