// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <limits>
#include <map>
#include <span>

namespace rastro {

/// Cells of an unbounded plane. They are held in tiles, squares of 64 x 64 cells; a tile takes memory from the first
/// time one of its cells is written. So memory grows with the area that was written to, not with its bounding box. All
/// other cells have the value `unwritten`.
template <typename Cell>
class TiledCells {
 public:
  static constexpr int side = 64;  ///< Of a tile, in cells.

 private:
  using Tile = std::array<Cell, static_cast<std::size_t>(side) * side>;
  struct TilePosition {
    int row = 0, column = 0;
    friend auto operator<=>(const TilePosition&, const TilePosition&) = default;
  };

 public:
  explicit TiledCells(Cell unwritten) : unwritten_(unwritten) {}

  Cell at(int x, int y) const {
    const auto tile = tiles_.find(tile_of(x, y));
    return tile == tiles_.end() ? unwritten_ : tile->second[index_in_tile(x, y)];
  }
  void set(int x, int y, Cell value) { Writer(*this).at(x, y) = value; }

  /// For cells one beside the other: the tile is searched for only where it is not that of the cell before. Valid as
  /// long as the cells are neither moved nor assigned to.
  class Writer {
   public:
    explicit Writer(TiledCells& cells) : cells_(cells) {}
    Cell& at(int x, int y) {
      const TilePosition position = tile_of(x, y);
      if (!tile_ || position != position_) {
        tile_ = &cells_.made_tile(position);
        position_ = position;
      }
      return (*tile_)[index_in_tile(x, y)];
    }

   private:
    TiledCells& cells_;
    Tile* tile_ = nullptr;
    TilePosition position_{};
  };

  /// The cells (first_x, y), (first_x + 1, y), ...
  void copy_row(int first_x, int y, std::span<Cell> row) const {
    std::fill(row.begin(), row.end(), unwritten_);
    const int end_x = first_x + static_cast<int>(row.size());
    for (auto tile = tiles_.lower_bound(tile_of(first_x, y)); tile != tiles_.end(); ++tile) {
      const int left = tile->first.column * side, from = std::max(left, first_x), to = std::min(left + side, end_x);
      if (tile->first.row != tile_of(first_x, y).row || from >= to) return;
      std::copy_n(tile->second.begin() + static_cast<std::ptrdiff_t>(index_in_tile(from, y)), to - from,
                  row.begin() + (from - first_x));
    }
  }

  /// Calls visit(x, y, value) for the cells of all tiles held, row by row: first the smallest y, in it the smallest x.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (auto first = tiles_.begin(); first != tiles_.end();) {
      const int row = first->first.row;
      const auto end = tiles_.upper_bound({row, std::numeric_limits<int>::max()});
      for (int y = row * side; y < (row + 1) * side; ++y) {
        for (auto tile = first; tile != end; ++tile) {
          const int left = tile->first.column * side;
          for (int x = left; x < left + side; ++x) visit(x, y, tile->second[index_in_tile(x, y)]);
        }
      }
      first = end;
    }
  }

  /// Calls change(cell) for the cells of all tiles held.
  template <typename Change>
  void change_each(const Change& change) {
    for (auto& [position, tile] : tiles_)
      for (Cell& cell : tile) change(cell);
  }

  /// Number of tiles held; each has side * side cells.
  std::size_t tiles() const { return tiles_.size(); }

  /// The same tiles with the same cells.
  friend bool operator==(const TiledCells&, const TiledCells&) = default;

 private:
  static constexpr int side_bits = 6;
  static_assert(side == 1 << side_bits);

  // Shifts and masks round down for negative numbers as well.
  static TilePosition tile_of(int x, int y) { return {y >> side_bits, x >> side_bits}; }
  static std::size_t index_in_tile(int x, int y) {
    return static_cast<std::size_t>(y & (side - 1)) * side + static_cast<std::size_t>(x & (side - 1));
  }

  Tile& made_tile(TilePosition position) {
    const auto [tile, is_new] = tiles_.try_emplace(position);
    if (is_new) tile->second.fill(unwritten_);
    return tile->second;
  }

  Cell unwritten_;
  std::map<TilePosition, Tile> tiles_;  ///< Row by row, as TilePosition is ordered.
};

}  // namespace rastro
