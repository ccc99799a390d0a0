// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/point_tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/viewer/block_writer.h"

namespace rastro {
namespace {

constexpr std::size_t axes = 3;
constexpr std::size_t octants = 8;

using Point = std::array<float, axes>;

struct TileCube {
  std::array<double, axes> center{};
  double half = 0.0;

  TileCube octant(std::size_t index) const {
    TileCube inside{center, half / 2};
    for (std::size_t axis = 0; axis < axes; ++axis)
      inside.center[axis] += (index >> axis & 1) != 0 ? half / 2 : -half / 2;
    return inside;
  }
  std::size_t octant_of(const Point& point) const {
    std::size_t index = 0;
    for (std::size_t axis = 0; axis < axes; ++axis)
      if (static_cast<double>(point[axis]) >= center[axis]) index |= std::size_t{1} << axis;
    return index;
  }
};

/// The cells of a raster over a cube that already hold a point.
class TakenCells {
 public:
  TakenCells(const TileCube& cube, std::size_t cells_per_axis)
      : cube_(cube), side_(cells_per_axis), taken_(side_ * side_ * side_, false) {}

  /// Whether the point is the first of its cell.
  bool take(const Point& point) {
    std::size_t cell = 0;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const double share = (static_cast<double>(point[axis]) - cube_.center[axis] + cube_.half) / (2 * cube_.half);
      const double along = std::clamp(share * static_cast<double>(side_), 0.0, static_cast<double>(side_ - 1));
      cell = cell * side_ + static_cast<std::size_t>(along);
    }
    if (taken_[cell]) return false;
    taken_[cell] = true;
    return true;
  }

 private:
  TileCube cube_;
  std::size_t side_;
  std::vector<bool> taken_;
};

/// Orders the points tile by tile.
class TileBuilder {
 public:
  TileBuilder(std::span<const float> positions, SceneTiles& index, std::vector<std::size_t>& begins,
              const TileProgress& progress)
      : positions_(positions), index_(index), begins_(begins), progress_(progress) {}

  /// Indices of the points, each tile's in ascending order, the tiles one after the other.
  std::vector<std::uint32_t> order() {
    add_finite_points();
    buffer_.resize(order_.size());
    waiting_.push_back({0, order_.size(), bounds(), -1, 0});
    while (!waiting_.empty()) {
      const Part part = waiting_.back();
      waiting_.pop_back();
      split(part);
    }
    return std::move(order_);
  }

 private:
  struct Part {
    std::size_t begin = 0, end = 0;  ///< Of order_.
    TileCube cube;
    std::int32_t parent = -1;
    int depth = 0;
    std::size_t count() const { return end - begin; }
  };
  static constexpr int deepest = 24;

  Point point(std::uint32_t index) const {
    return {positions_[axes * index], positions_[axes * index + 1], positions_[axes * index + 2]};
  }

  void add_finite_points() {
    order_.reserve(positions_.size() / axes);
    for (std::size_t k = 0; axes * k < positions_.size(); ++k) {
      const Point at = point(static_cast<std::uint32_t>(k));
      if (std::all_of(at.begin(), at.end(), [](float each) { return std::isfinite(each); }))
        order_.push_back(static_cast<std::uint32_t>(k));
    }
  }

  TileCube bounds() const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::array<double, axes> low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
    for (const std::uint32_t index : order_) {
      const Point at = point(index);
      for (std::size_t axis = 0; axis < axes; ++axis) {
        low[axis] = std::min(low[axis], static_cast<double>(at[axis]));
        high[axis] = std::max(high[axis], static_cast<double>(at[axis]));
      }
    }
    TileCube cube{{}, 1e-6};
    for (std::size_t axis = 0; axis < axes && !order_.empty(); ++axis) {
      cube.center[axis] = (low[axis] + high[axis]) / 2;
      cube.half = std::max(cube.half, (high[axis] - low[axis]) / 2);
    }
    return cube;
  }

  void split(const Part& part) {
    const std::size_t before = index_.parents.size();
    double spacing = 0.0;
    const std::size_t kept = sample(part, spacing);
    add_tile(part, kept, spacing);
    const Part rest{part.begin + kept, part.end, part.cube, static_cast<std::int32_t>(before), part.depth + 1};
    if (rest.count() == 0) return;
    if (part.depth >= deepest) return waiting_.push_back(rest);  // the points are all but one
    split_by_octant(rest);
  }

  void add_tile(const Part& part, std::size_t kept, double spacing) {
    for (const double each : part.cube.center) index_.cubes.push_back(static_cast<float>(each));
    index_.cubes.push_back(static_cast<float>(part.cube.half));
    index_.spacings.push_back(static_cast<float>(spacing));
    index_.parents.push_back(part.parent);
    index_.counts.push_back(static_cast<std::uint32_t>(kept));
    begins_.push_back(part.begin);
    placed_ += kept;
    if (progress_) progress_(placed_, order_.size());
  }

  /// Brings the points that the tile keeps to the begin of the part; returns how many.
  std::size_t sample(const Part& part, double& spacing) {
    constexpr std::size_t most = PointTiles::most_points;
    if (part.count() <= most) return part.count();
    if (part.depth >= deepest) return most;
    if (part.parent < 0) return sample_by_number(part, spacing);
    return sample_by_place(part, spacing);
  }

  /// Of the whole: as dense as the points are, so that a few that lie far away do not count more than the others.
  std::size_t sample_by_number(const Part& part, double& spacing) {
    constexpr std::size_t most = PointTiles::most_points;
    spacing = 2 * part.cube.half / std::sqrt(static_cast<double>(most));
    std::size_t chosen = 0;
    return bring(part, [&](std::size_t k) {
      const bool is_next = chosen < most && k - part.begin == chosen * part.count() / most;
      chosen += is_next ? 1 : 0;
      return is_next;
    });
  }

  /// The first of each cell of a raster, as fine as the tile may hold.
  std::size_t sample_by_place(const Part& part, double& spacing) {
    constexpr double finest = 128.0, coarser = 0.8;
    for (double cells_per_axis = finest;; cells_per_axis *= coarser) {
      TakenCells cells(part.cube, static_cast<std::size_t>(cells_per_axis));
      const std::size_t kept = bring(part, [&](std::size_t k) { return cells.take(point(order_[k])); });
      spacing = 2 * part.cube.half / std::floor(cells_per_axis);
      if (kept <= PointTiles::most_points) return kept;
    }
  }

  /// How many the part has of which `is_kept`; the order changes only where the tile may hold as many.
  template <typename IsKept>
  std::size_t bring(const Part& part, IsKept is_kept) {
    std::size_t kept = 0, left = 0;
    for (std::size_t k = part.begin; k < part.end; ++k) {
      const bool keep = is_kept(k);
      if (keep && ++kept > PointTiles::most_points) return kept;
      // The kept ones from the front, the others from the back: the tile's own size is not known before.
      if (keep)
        buffer_[part.begin + kept - 1] = order_[k];
      else
        buffer_[part.end - ++left] = order_[k];
    }
    const auto at = [](std::vector<std::uint32_t>& all, std::size_t k) {
      return all.begin() + static_cast<std::ptrdiff_t>(k);
    };
    std::reverse(at(buffer_, part.begin + kept), at(buffer_, part.end));
    std::copy(at(buffer_, part.begin), at(buffer_, part.end), at(order_, part.begin));
    return kept;
  }

  void split_by_octant(const Part& rest) {
    std::array<std::size_t, octants> counts{};
    for (std::size_t k = rest.begin; k < rest.end; ++k) ++counts[rest.cube.octant_of(point(order_[k]))];
    std::array<std::size_t, octants> ends{};
    std::exclusive_scan(counts.begin(), counts.end(), ends.begin(), rest.begin);
    for (std::size_t k = rest.begin; k < rest.end; ++k)
      buffer_[ends[rest.cube.octant_of(point(order_[k]))]++] = order_[k];
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(rest.begin),
              buffer_.begin() + static_cast<std::ptrdiff_t>(rest.end),
              order_.begin() + static_cast<std::ptrdiff_t>(rest.begin));
    for (std::size_t octant = octants; octant-- > 0;)
      if (counts[octant] > 0)
        waiting_.push_back(
            {ends[octant] - counts[octant], ends[octant], rest.cube.octant(octant), rest.parent, rest.depth});
  }

  std::span<const float> positions_;
  SceneTiles& index_;
  std::vector<std::size_t>& begins_;
  const TileProgress& progress_;
  std::size_t placed_ = 0;
  std::vector<std::uint32_t> order_, buffer_;
  std::vector<Part> waiting_;
};

template <typename Number>
void reorder(std::vector<Number>& numbers, std::size_t columns, const std::vector<std::uint32_t>& order) {
  if (numbers.empty()) return;
  std::vector<Number> sorted(columns * order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    for (std::size_t column = 0; column < columns; ++column)
      sorted[columns * k + column] = numbers[columns * order[k] + column];
  numbers = std::move(sorted);
}

template <typename Number>
std::vector<Number> rows_of(const std::vector<Number>& numbers, std::size_t columns, std::size_t begin,
                            std::size_t count) {
  if (numbers.empty()) return {};
  const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(columns * begin);
  return {first, first + static_cast<std::ptrdiff_t>(columns * count)};
}

}  // namespace

PointTiles::PointTiles(ScenePoints points, const TileProgress& progress) : points_(std::move(points)) {
  RASTRO_CHECK(points_.positions.size() % axes == 0, "whole points");
  RASTRO_CHECK(points_.positions.size() / axes < std::numeric_limits<std::uint32_t>::max(),
               "points have 32-bit numbers");
  const std::vector<std::uint32_t> order = TileBuilder(points_.positions, index_, begins_, progress).order();
  index_.count = order.size();
  reorder(points_.positions, axes, order);
  reorder(points_.colors, 3, order);
  reorder(points_.sigmas, 1, order);
  reorder(points_.keyframes, 1, order);
}

ScenePoints PointTiles::tile(std::size_t row) const {
  const std::size_t begin = begins_.at(row), count = index_.counts.at(row);
  ScenePoints points;
  points.name = points_.name;
  points.positions = rows_of(points_.positions, axes, begin, count);
  points.colors = rows_of(points_.colors, 3, begin, count);
  points.sigmas = rows_of(points_.sigmas, 1, begin, count);
  points.keyframes = rows_of(points_.keyframes, 1, begin, count);
  return points;
}

std::optional<std::string> PointTiles::block(std::uint64_t row) const {
  if (row >= begins_.size()) return std::nullopt;
  const ScenePoints points = tile(static_cast<std::size_t>(row));
  detail::BlockBody body;
  nlohmann::ordered_json header{{"type", "tile"}, {"positions", body.put(points.positions)}};
  body.put_if_any(header, "colors", points.colors);
  body.put_if_any(header, "sigmas", points.sigmas);
  body.put_if_any(header, "keyframes", points.keyframes);
  return detail::block_of(header, body);
}

std::function<std::optional<std::string>(std::uint64_t, std::uint64_t)> tile_large_layers(
    ViewScene& scene, std::size_t most, const TileProgress& progress) {
  std::vector<std::shared_ptr<const PointTiles>> tiled;
  for (SceneLayer& layer : scene.layers) {
    auto* points = std::get_if<ScenePoints>(&layer);
    if (points == nullptr || points->positions.size() / axes <= most) continue;
    const auto tiles = std::make_shared<const PointTiles>(std::move(*points), progress);
    *points = tiles->tile(0);
    points->tiles = tiles->index();
    points->tiles->layer = static_cast<std::uint32_t>(tiled.size());
    tiled.push_back(tiles);
  }
  if (tiled.empty()) return {};
  return [tiled](std::uint64_t layer, std::uint64_t tile) -> std::optional<std::string> {
    return layer < tiled.size() ? tiled[static_cast<std::size_t>(layer)]->block(tile) : std::nullopt;
  };
}

}  // namespace rastro
