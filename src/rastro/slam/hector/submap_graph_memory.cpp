// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "rastro/slam/hector/submap_graph.h"

namespace rastro {

std::size_t SubmapGraph::bytes() const {
  std::size_t bytes = poses_.size() * sizeof(SE2) + constraints_.size() * sizeof(Constraint) +
                      loops_.size() * sizeof(ClosedLoop) +
                      (pose_of_submap_.size() + pose_of_key_scan_.size() + after_gaps_.size()) * sizeof(std::size_t);
  for (const auto& submap : submaps_) bytes += submap->bytes();
  for (const KeyScan& key_scan : key_scans_)
    bytes += sizeof(KeyScan) + key_scan.scan.points.size() * sizeof(Eigen::Vector2d);
  return bytes;
}

/// Submaps overlap by half: without every second one, the others still cover the mapped area.
std::string SubmapGraph::give_up_redundant() {
  if (release_submap(2)) return "the cells of a submap that others overlap were dropped";
  if (thin_key_scans()) return "every second point of the key scans was dropped";
  if (release_submap(1)) return "the cells of the oldest submap were dropped";
  return "";
}

/// The oldest of every `step`-th one.
bool SubmapGraph::release_submap(std::size_t step) {
  for (std::size_t s = step - 1; s < submaps_.size(); s += step) {
    if (!submaps_[s]->finished() || submaps_[s]->released()) continue;
    submaps_[s]->release();
    return true;
  }
  return false;
}

bool SubmapGraph::thin_key_scans() {
  constexpr std::size_t least_points = 40;
  bool thinned = false;
  for (KeyScan& key_scan : key_scans_) {
    std::vector<Eigen::Vector2d>& points = key_scan.scan.points;
    if (points.size() < 2 * least_points) continue;
    std::vector<Eigen::Vector2d> kept;
    kept.reserve(points.size() / 2 + 1);
    for (std::size_t i = 0; i < points.size(); i += 2) kept.push_back(points[i]);
    points = std::move(kept);
    thinned = true;
  }
  return thinned;
}

}  // namespace rastro
