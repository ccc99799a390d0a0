// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/pose_graph_g2o.h"

namespace rastro {

std::string pose_graph_g2o(const Map& map, int submap, GraphSize* size) {
  std::string text = g2o::head(map);
  const std::size_t vertices = g2o::append_vertices(text, map, submap);
  std::size_t edges = 0;
  for (const Constraint& each : map.constraints) {
    const Keyframe *from = map.find(each.from), *to = map.find(each.to);
    if (!from || !to || (submap >= 0 && (from->submap != submap || to->submap != submap))) continue;
    const bool used = each.weight > 0.0;
    if (!used) text += "# switched off: ";
    g2o::append_edge(text, each.from, each.to, each.rigid(), (used ? each.weight : 1.0) * each.information);
    if (used) ++edges;
  }
  if (size) *size = {vertices, edges};
  return text;
}

}  // namespace rastro
