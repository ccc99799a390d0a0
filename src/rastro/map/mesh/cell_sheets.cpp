// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/mesh/cell_sheets.h"

#include <utility>

namespace rastro::detail {
namespace {

/// The corners and edges of a face in cyclic order: edge k is between corners k and k + 1.
struct Face {
  std::array<int, 4> corners, edges;
};

Face face_at(int axis, int side) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto corner = [&](int at_u, int at_v) { return side << axis | at_u << u | at_v << v; };
  return {{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)},
          {edge_at(u, corner(0, 0)), edge_at(v, corner(1, 0)), edge_at(u, corner(0, 1)), edge_at(v, corner(0, 0))}};
}

bool is_solid(std::uint8_t solid, int corner) { return (solid >> corner & 1) != 0; }

/// Pairs of crossed edges that a surface connects on a face; the second pair exists on ambiguous faces only.
struct Connections {
  int count = 0;
  std::array<std::pair<int, int>, 2> pairs;
};

Connections connections_of(std::uint8_t solid, int axis, int side, bool connected) {
  const Face face = face_at(axis, side);
  std::array<int, 4> crossed{};
  int count = 0;
  for (int k = 0; k < 4; ++k) {
    const auto here = static_cast<std::size_t>(k), next = static_cast<std::size_t>((k + 1) % 4);
    if (is_solid(solid, face.corners[here]) != is_solid(solid, face.corners[next]))
      crossed[static_cast<std::size_t>(count++)] = face.edges[here];
  }
  if (count == 2) return {1, {std::pair(crossed[0], crossed[1])}};
  if (count == 0) return {};
  // Corner 0 is between edges 3 and 0; cutting off corners 0 and 2 leaves 1 and 3 connected.
  const bool cut_first = is_solid(solid, face.corners[0]) != connected;
  const auto& e = face.edges;
  return cut_first ? Connections{2, {std::pair(e[3], e[0]), std::pair(e[1], e[2])}}
                   : Connections{2, {std::pair(e[0], e[1]), std::pair(e[2], e[3])}};
}

}  // namespace

CellSheets sheets_of(std::uint8_t solid, std::uint8_t connected) {
  CellSheets sheets;
  sheets.of_edge.fill(-1);
  std::array<std::array<std::int8_t, 2>, 12> neighbors;
  std::array<int, 12> degree{};
  for (int face = 0; face < 6; ++face) {
    const Connections connections = connections_of(solid, face / 2, face % 2, (connected >> face & 1) != 0);
    for (int k = 0; k < connections.count; ++k) {
      const auto [a, b] = connections.pairs[static_cast<std::size_t>(k)];
      const auto at = static_cast<std::size_t>(a), to = static_cast<std::size_t>(b);
      neighbors[at][static_cast<std::size_t>(degree[at]++)] = static_cast<std::int8_t>(b);
      neighbors[to][static_cast<std::size_t>(degree[to]++)] = static_cast<std::int8_t>(a);
    }
  }
  for (std::size_t first = 0; first < 12; ++first) {
    if (degree[first] == 0 || sheets.of_edge[first] >= 0) continue;
    const auto number = static_cast<std::int8_t>(sheets.count++);
    // Each crossed edge is on two faces, so the edges of a sheet form a cycle.
    for (std::size_t at = first; sheets.of_edge[at] < 0;) {
      sheets.of_edge[at] = number;
      const auto next = static_cast<std::size_t>(neighbors[at][0]);
      at = sheets.of_edge[next] < 0 ? next : static_cast<std::size_t>(neighbors[at][1]);
    }
  }
  return sheets;
}

namespace {

/// Whether a face is ambiguous and both surface parts through it belong to one sheet of the cell.
bool one_sheet_through(std::uint8_t solid, int axis, int side) {
  const Connections connections = connections_of(solid, axis, side, false);
  if (connections.count < 2) return false;
  const CellSheets sheets = sheets_of(solid);
  return sheets.of_edge[static_cast<std::size_t>(connections.pairs[0].first)] ==
         sheets.of_edge[static_cast<std::size_t>(connections.pairs[1].first)];
}

}  // namespace

std::uint8_t connected_faces(std::uint8_t solid, const std::function<std::uint8_t(int axis, int side)>& beyond) {
  std::uint8_t connected = 0;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, side = face % 2;
    if (one_sheet_through(solid, axis, side) && one_sheet_through(beyond(axis, side), axis, 1 - side))
      connected = static_cast<std::uint8_t>(connected | 1U << face);
  }
  return connected;
}

}  // namespace rastro::detail
