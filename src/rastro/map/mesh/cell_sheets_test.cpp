// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/mesh/cell_sheets.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>
#include <vector>

#include "rastro/base/random.h"

namespace rastro::detail {
namespace {

TEST(CellSheets, HaveOneForEachGroupOfCorners) {
  EXPECT_EQ(sheets_of(0).count, 0);
  EXPECT_EQ(sheets_of(255).count, 0);
  EXPECT_EQ(sheets_of(0b00000001).count, 1);
  EXPECT_EQ(sheets_of(0b00001111).count, 1) << "a plane";
  EXPECT_EQ(sheets_of(0b10000001).count, 2) << "two opposite corners";
  EXPECT_EQ(sheets_of(0b01111110).count, 2) << "all but them: the free ones";
  EXPECT_EQ(sheets_of(0b01101001).count, 4) << "every other corner";
  EXPECT_EQ(sheets_of(0b00001001).count, 2) << "two corners of a face, disconnected";
  EXPECT_EQ(sheets_of(0b00001001, 1U << face_of(2, 0)).count, 1) << "and together";
}

TEST(CellSheets, EveryCrossedEdgeHasASheetAndNoOtherHas) {
  for (unsigned solid = 0; solid < 256; ++solid) {
    const CellSheets sheets = sheets_of(static_cast<std::uint8_t>(solid));
    EXPECT_LE(sheets.count, 4);
    for (int k = 0; k < 8; ++k)
      for (int axis = 0; axis < 3; ++axis)
        if ((k >> axis & 1) == 0) {
          const bool crossed = (solid >> k & 1U) != (solid >> (k | 1 << axis) & 1U);
          const int sheet = sheets.of_edge[static_cast<std::size_t>(edge_at(axis, k))];
          EXPECT_EQ(sheet >= 0, crossed);
          EXPECT_LT(sheet, sheets.count);
        }
  }
}

/// Random corners in a box whose outermost ones are free, so that every surface is closed.
class RandomGrid {
 public:
  static constexpr int side = 9;

  RandomGrid(std::uint64_t seed, double share) {
    Random random(seed);
    for (int z = 0; z < side; ++z)
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
          const bool inner = x > 0 && y > 0 && z > 0 && x < side - 1 && y < side - 1 && z < side - 1;
          solid_.push_back(random.uniform() < share && inner);
        }
  }
  bool solid(int x, int y, int z) const { return solid_[static_cast<std::size_t>((z * side + y) * side + x)]; }
  std::uint8_t cell(int x, int y, int z) const {
    if (x < 0 || y < 0 || z < 0 || x >= side - 1 || y >= side - 1 || z >= side - 1) return 0;
    unsigned bits = 0;
    for (int k = 0; k < 8; ++k) bits |= (solid(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2 & 1)) ? 1U : 0U) << k;
    return static_cast<std::uint8_t>(bits);
  }
  /// Cell and sheet.
  using Vertex = std::tuple<int, int, int, int>;
  Vertex vertex(int x, int y, int z, int edge) const {
    const std::uint8_t bits = cell(x, y, z);
    const auto beyond = [&](int axis, int at) {
      const int step = at == 1 ? 1 : -1;
      return cell(x + (axis == 0 ? step : 0), y + (axis == 1 ? step : 0), z + (axis == 2 ? step : 0));
    };
    const CellSheets sheets = sheets_of(bits, connected_faces(bits, beyond));
    return {x, y, z, sheets.of_edge[static_cast<std::size_t>(edge)]};
  }

 private:
  std::vector<bool> solid_;
};

/// Number of four-corner faces at each edge of the mesh.
std::map<std::pair<RandomGrid::Vertex, RandomGrid::Vertex>, int> faces_at_edges(const RandomGrid& grid) {
  std::map<std::pair<RandomGrid::Vertex, RandomGrid::Vertex>, int> faces;
  for (int z = 0; z < RandomGrid::side - 1; ++z)
    for (int y = 0; y < RandomGrid::side - 1; ++y)
      for (int x = 0; x < RandomGrid::side - 1; ++x)
        for (int axis = 0; axis < 3; ++axis) {
          const int there[] = {x + (axis == 0 ? 1 : 0), y + (axis == 1 ? 1 : 0), z + (axis == 2 ? 1 : 0)};
          if (grid.solid(x, y, z) == grid.solid(there[0], there[1], there[2])) continue;
          std::vector<RandomGrid::Vertex> round;
          for (const auto& [u, v] : {std::pair(1, 1), std::pair(0, 1), std::pair(0, 0), std::pair(1, 0)}) {
            int cell[] = {x, y, z};
            cell[(axis + 1) % 3] -= u, cell[(axis + 2) % 3] -= v;
            round.push_back(grid.vertex(cell[0], cell[1], cell[2], edge_of(axis, u, v)));
          }
          for (std::size_t k = 0; k < 4; ++k) ++faces[std::minmax(round[k], round[(k + 1) % 4])];
        }
  return faces;
}

TEST(CellSheets, NoTwoSurfacesShareAnEdgeOfTheMesh) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    for (const double share : {0.1, 0.5, 0.8}) {
      const auto faces = faces_at_edges(RandomGrid(seed, share));
      ASSERT_GT(faces.size(), 50U);
      for (const auto& [edge, count] : faces) ASSERT_EQ(count, 2) << "seed " << seed << ", share " << share;
    }
  }
}

}  // namespace
}  // namespace rastro::detail
