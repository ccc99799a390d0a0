// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <queue>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace rastro {

/// Lengths of the shortest paths from one node of a graph (Dijkstra 1959). Goes only as far as it is asked, so that the
/// time depends on how near the others are, not on the size of the graph.
class GraphPaths {
 public:
  struct Link {
    std::int64_t other = 0;
    double length = 0.0;  ///< Not negative.
  };
  using LinksOf = std::function<std::vector<Link>(std::int64_t)>;

  /// `links_of` a node must not change as long as paths are asked for.
  GraphPaths(std::int64_t from, LinksOf links_of);
  /// Infinity: there is none.
  double to(std::int64_t node);

 private:
  using Reached = std::pair<double, std::int64_t>;

  LinksOf links_of_;
  std::unordered_map<std::int64_t, double> shortest_;  ///< So far; those not in next_ are final.
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next_;
};

}  // namespace rastro
