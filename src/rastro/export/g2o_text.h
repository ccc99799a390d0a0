// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "rastro/map/graph/map.h"

namespace rastro {

/// What was written.
struct GraphSize {
  std::size_t vertices = 0, edges = 0;
};

namespace g2o {

/// The first line: what the numbers are, in which unit.
std::string head(const Map& map);
/// VERTEX_SE3:QUAT of the keyframes of a submap (-1: of all), and FIX of the first one of each.
std::size_t append_vertices(std::string& text, const Map& map, int submap);
/// EDGE_SE3:QUAT with the upper triangle of the information of (translation, vector part of the quaternion), which is
/// half a rotation vector; `information` is that of (translation, rotation vector), as in Constraint.
void append_edge(std::string& text, KeyframeId from, KeyframeId to, const SE3& from_from_to,
                 const Matrix6d& information);

}  // namespace g2o
}  // namespace rastro
