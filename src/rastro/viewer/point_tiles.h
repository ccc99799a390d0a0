// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rastro/viewer/scene.h"

namespace rastro {

/// Points that are in a tile, and all.
using TileProgress = std::function<void(std::size_t done, std::size_t all)>;

/// Many points as an octree of tiles with level of detail, made once. The root keeps a sample of all; any other tile
/// with more points than it may hold the first of each cell of a raster over its cube; the others go to the eight cubes
/// inside. So every point is in exactly one tile, and a cube is seen the finer the deeper one goes. The same tiles for
/// the same points. While it is built it needs 20 bytes a point beside the points, afterwards none.
class PointTiles {
 public:
  static constexpr std::size_t most_points = 40'000;  ///< Of a tile.

  /// Points without finite positions are left out.
  explicit PointTiles(ScenePoints points, const TileProgress& progress = {});

  const SceneTiles& index() const { return index_; }
  /// The points of a tile, in their order; `row` < the number of tiles.
  ScenePoints tile(std::size_t row) const;
  /// The same as the page reads it; nullopt where there is no such tile.
  std::optional<std::string> block(std::uint64_t row) const;

 private:
  ScenePoints points_;  ///< Tile by tile.
  SceneTiles index_;
  std::vector<std::size_t> begins_;  ///< First point of each tile.
};

/// Makes tiles of the layers of points with more than `most`, which keep those of the root. What NamedScene::tile_block
/// wants; empty where no layer is so large.
std::function<std::optional<std::string>(std::uint64_t layer, std::uint64_t tile)> tile_large_layers(
    ViewScene& scene, std::size_t most, const TileProgress& progress = {});

}  // namespace rastro
