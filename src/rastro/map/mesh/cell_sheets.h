// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

namespace rastro::detail {

/// The sheets of surface that cross a cell of a grid, and the edges each crosses. A cell whose solid corners are not
/// all connected has several sheets. Each gets a vertex of its own; otherwise surfaces would touch in edges with four
/// faces (dual marching cubes: Nielson 2004; Schaefer, Ju and Warren 2007).
struct CellSheets {
  int count = 0;
  std::array<std::int8_t, 12> of_edge{};  ///< Sheet through each edge; -1: the surface does not cross it.
};

/// Edges and corners of a cell: corner bits are x, y, z; an edge is numbered by its axis and the bits of its first
/// corner along the next axis and the one after.
constexpr int edge_of(int axis, int next, int after) { return 4 * axis + (next | after << 1); }
constexpr int edge_at(int axis, int corner) {
  return edge_of(axis, corner >> (axis + 1) % 3 & 1, corner >> (axis + 2) % 3 & 1);
}
/// Faces: two per axis, the one of the first corner first.
constexpr int face_of(int axis, int side) { return 2 * axis + side; }

/// `solid`: one bit per corner. On ambiguous faces solid corners are disconnected, on those in `connected` (one bit per
/// face) connected; cells that share a face must agree on it.
CellSheets sheets_of(std::uint8_t solid, std::uint8_t connected = 0);

/// The faces on which solid corners are connected: the ambiguous ones where two sheets would otherwise share one edge
/// of the mesh, since both cells have them in one sheet (Wenger 2013, "Isosurfaces", section 3.4). `beyond` returns the
/// solid corners of the cell beyond the face of an axis and side; it is called for ambiguous faces only.
std::uint8_t connected_faces(std::uint8_t solid, const std::function<std::uint8_t(int axis, int side)>& beyond);

}  // namespace rastro::detail
