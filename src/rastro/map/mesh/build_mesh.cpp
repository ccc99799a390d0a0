// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/mesh/build_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/images/map_views.h"
#include "rastro/map/mesh/cell_sheets.h"
#include "rastro/map/mesh/distance_volume.h"

namespace rastro {
namespace {

using detail::block_cells;
using detail::block_side;
using detail::CellSheets;
using detail::DistanceBlock;
using detail::DistanceVolume;
using detail::DistanceVoxel;
using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr float steepest = 2.0F;  ///< Distances change by at most one voxel between neighbors, except for noise.

Vector3i corner(int index) { return {index & 1, index >> 1 & 1, index >> 2 & 1}; }

using Corners = std::array<const DistanceVoxel*, 8>;

/// The voxels around a block's cells: its own and those of the adjacent blocks.
class Neighborhood {
 public:
  Neighborhood(const DistanceVolume& volume, const DistanceBlock& block) {
    for (int index = 0; index < 8; ++index) {
      const int found = volume.block_at(block.index + corner(index));
      blocks_[static_cast<std::size_t>(index)] =
          found < 0 ? nullptr : volume.blocks()[static_cast<std::size_t>(found)].get();
    }
  }
  /// 0 to 8 along each axis; null where there is no block.
  const DistanceVoxel* at(const Vector3i& cell) const {
    const Vector3i block = cell / block_side, inside = cell - block_side * block;
    const DistanceBlock* found = blocks_[static_cast<std::size_t>(block.x() + 2 * block.y() + 4 * block.z())];
    if (found == nullptr) return nullptr;
    return &found->voxels[static_cast<std::size_t>((inside.z() * block_side + inside.y()) * block_side + inside.x())];
  }

 private:
  std::array<const DistanceBlock*, 8> blocks_;
};

/// The vertices of a cell: one per sheet, in their order.
struct CellVertices {
  std::int32_t first = -1;     ///< -1: none.
  std::uint32_t sheet_of = 0;  ///< Two bits per edge.

  std::int32_t at(int edge) const { return first + static_cast<std::int32_t>(sheet_of >> 2 * edge & 3U); }
};

/// The vertices of a block, and those of each of its cells.
struct BlockNet {
  std::vector<MeshVertex> vertices;
  std::array<CellVertices, block_cells> vertices_of{};
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

class SurfaceNet {
 public:
  SurfaceNet(const DistanceVolume& volume, int min_views) : volume_(volume), min_views_(min_views) {}

  TriangleMesh make(TaskPool* pool) {
    nets_.resize(volume_.blocks().size());
    detail::for_each_index(pool, nets_.size(), [&](std::size_t block) { make_vertices(block); });
    first_.assign(nets_.size() + 1, 0);
    for (std::size_t k = 0; k < nets_.size(); ++k)
      first_[k + 1] = first_[k] + static_cast<std::uint32_t>(nets_[k].vertices.size());
    detail::for_each_index(pool, nets_.size(), [&](std::size_t block) { connect_faces(block); });
    TriangleMesh mesh;
    for (const BlockNet& net : nets_) {
      mesh.vertices.insert(mesh.vertices.end(), net.vertices.begin(), net.vertices.end());
      mesh.triangles.insert(mesh.triangles.end(), net.triangles.begin(), net.triangles.end());
    }
    return mesh;
  }

 private:
  bool is_known(const DistanceVoxel* voxel) const {
    return voxel != nullptr && voxel->weight > 0.0F && voxel->views >= min_views_;
  }

  void make_vertices(std::size_t index) {
    const DistanceBlock& block = *volume_.blocks()[index];
    const Neighborhood around(volume_, block);
    BlockNet& net = nets_[index];
    for (int cell = 0; cell < block_cells; ++cell) {
      const Vector3i inside(cell % block_side, cell / block_side % block_side, cell / (block_side * block_side));
      Corners corners{};
      for (int k = 0; k < 8; ++k) corners[static_cast<std::size_t>(k)] = around.at(inside + corner(k));
      const std::uint8_t solid = solid_corners(corners);
      if (solid == 0 || solid == 255 || !is_smooth(corners)) continue;
      const auto beyond = [&](int axis, int side) {
        return solid_at(block.index, inside + (side == 1 ? 1 : -1) * Vector3i::Unit(axis));
      };
      const CellSheets sheets = detail::sheets_of(solid, detail::connected_faces(solid, beyond));
      const auto base = (block_side * block.index + inside).cast<float>() + Vector3f::Constant(0.5F);
      CellVertices& vertices = net.vertices_of[static_cast<std::size_t>(cell)];
      vertices.first = static_cast<std::int32_t>(net.vertices.size());
      for (int edge = 0; edge < 12; ++edge)
        if (const int sheet = sheets.of_edge[static_cast<std::size_t>(edge)]; sheet > 0)
          vertices.sheet_of |= static_cast<std::uint32_t>(sheet) << 2 * edge;
      for (int sheet = 0; sheet < sheets.count; ++sheet) {
        MeshVertex vertex = vertex_of(corners, sheets, sheet);
        vertex.position = static_cast<float>(volume_.voxel_m()) * (base + vertex.position);
        net.vertices.push_back(vertex);
      }
    }
  }

  /// One bit for each corner behind the surface; also 0 if a corner is unknown.
  std::uint8_t solid_corners(const Corners& corners) const {
    std::uint8_t solid = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      if (!is_known(corners[k])) return 0;
      if (corners[k]->distance < 0.0F) solid = static_cast<std::uint8_t>(solid | 1U << k);
    }
    return solid;
  }

  /// The same for any cell, of a block near `block`.
  std::uint8_t solid_at(const Vector3i& block, const Vector3i& cell) const {
    Corners corners{};
    for (int k = 0; k < 8; ++k) {
      const Vector3i voxel = block_side * block + cell + corner(k);
      const Vector3i block_index = voxel.unaryExpr(
          [](int value) { return value >= 0 ? value / block_side : -((block_side - 1 - value) / block_side); });
      const int found = volume_.block_at(block_index);
      if (found < 0) return 0;
      const Vector3i inside = voxel - block_side * block_index;
      corners[static_cast<std::size_t>(k)] =
          &volume_.blocks()[static_cast<std::size_t>(found)]
               ->voxels[static_cast<std::size_t>((inside.z() * block_side + inside.y()) * block_side + inside.x())];
    }
    return solid_corners(corners);
  }

  /// No step from far in front to far behind: that is the border of a surface and an occluded one behind it.
  bool is_smooth(const Corners& corners) const {
    for (int k = 0; k < 8; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        if (k >> axis & 1) continue;
        const float a = corners[static_cast<std::size_t>(k)]->distance;
        const float b = corners[static_cast<std::size_t>(k | 1 << axis)]->distance;
        if ((a < 0.0F) != (b < 0.0F) && std::abs(a - b) > steepest * static_cast<float>(volume_.voxel_m()))
          return false;
      }
    }
    return true;
  }

  /// The mean of the points where the edges of a sheet cross the surface, in cells from its first corner.
  static MeshVertex vertex_of(const Corners& corners, const CellSheets& sheets, int sheet) {
    MeshVertex vertex;
    Vector3f position = Vector3f::Zero(), gradient = Vector3f::Zero(), color = Vector3f::Zero();
    int crossings = 0;
    for (int k = 0; k < 8; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        if (k >> axis & 1) continue;
        const DistanceVoxel &a = *corners[static_cast<std::size_t>(k)],
                            &b = *corners[static_cast<std::size_t>(k | 1 << axis)];
        const int through = sheets.of_edge[static_cast<std::size_t>(detail::edge_at(axis, k))];
        // In a cell with one sheet, the gradient uses all edges; with several, those that the sheet crosses.
        if (sheets.count == 1 || through == sheet) gradient[axis] += b.distance - a.distance;
        if (through != sheet) continue;
        const float share = a.distance / (a.distance - b.distance);
        Vector3f crossing = corner(k).cast<float>();
        crossing[axis] += share;
        position += crossing;
        for (int c = 0; c < 3; ++c) {
          const auto channel = static_cast<std::size_t>(c);
          color[c] += (1.0F - share) * a.color[channel] + share * b.color[channel];
        }
        ++crossings;
      }
    }
    vertex.position = position / static_cast<float>(crossings);
    if (gradient.norm() > 0.0F) vertex.normal = gradient.normalized();
    for (std::size_t c = 0; c < 3; ++c)
      vertex.color[c] = static_cast<std::uint8_t>(std::lround(color[static_cast<int>(c)] / crossings));
    return vertex;
  }

  /// Index of the vertex of the sheet through an edge of a cell; -1: none. `cell` may be one before the block.
  std::int64_t vertex_at(std::size_t index, const Vector3i& cell, int edge) const {
    Vector3i block_index = volume_.blocks()[index]->index, inside = cell;
    for (int axis = 0; axis < 3; ++axis)
      if (inside[axis] < 0) inside[axis] += block_side, --block_index[axis];
    const int block =
        block_index == volume_.blocks()[index]->index ? static_cast<int>(index) : volume_.block_at(block_index);
    if (block < 0) return -1;
    const auto found = static_cast<std::size_t>(block);
    const CellVertices& vertices =
        nets_[found]
            .vertices_of[static_cast<std::size_t>((inside.z() * block_side + inside.y()) * block_side + inside.x())];
    return vertices.first < 0 ? -1 : static_cast<std::int64_t>(first_[found]) + vertices.at(edge);
  }

  void connect_faces(std::size_t index) {
    const Neighborhood around(volume_, *volume_.blocks()[index]);
    for (int cell = 0; cell < block_cells; ++cell) {
      const Vector3i inside(cell % block_side, cell / block_side % block_side, cell / (block_side * block_side));
      const DistanceVoxel* from = around.at(inside);
      if (!is_known(from)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const DistanceVoxel* to = around.at(inside + Vector3i::Unit(axis));
        if (is_known(to) && (from->distance < 0.0F) != (to->distance < 0.0F))
          connect_face(index, inside, axis, from->distance < 0.0F);
      }
    }
  }

  /// Connects the four cells around a grid edge that crosses the surface; `outwards`: it leaves the solid along the
  /// axis.
  void connect_face(std::size_t index, const Vector3i& inside, int axis, bool outwards) {
    const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
    const auto around = [&](int at_u, int at_v) {
      return vertex_at(index, inside - at_u * u - at_v * v, detail::edge_of(axis, at_u, at_v));
    };
    std::array<std::int64_t, 4> quad{around(1, 1), around(0, 1), around(0, 0), around(1, 0)};
    if (std::any_of(quad.begin(), quad.end(), [](std::int64_t vertex) { return vertex < 0; })) return;
    if (!outwards) std::swap(quad[1], quad[3]);
    const auto at = [&](std::size_t k) { return static_cast<std::uint32_t>(quad[k]); };
    nets_[index].triangles.push_back({at(0), at(1), at(2)});
    nets_[index].triangles.push_back({at(0), at(2), at(3)});
  }

  const DistanceVolume& volume_;
  int min_views_;
  std::vector<BlockNet> nets_;
  std::vector<std::uint32_t> first_;
};

/// Removes vertices without a triangle.
void drop_loose_vertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> moved(mesh.vertices.size(), 0);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle) moved[vertex] = 1;
  std::uint32_t kept = 0;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    if (moved[k] == 0) continue;
    mesh.vertices[kept] = mesh.vertices[k];
    moved[k] = kept++;
  }
  mesh.vertices.resize(kept);
  for (auto& triangle : mesh.triangles)
    for (std::uint32_t& vertex : triangle) vertex = moved[vertex];
}

}  // namespace

TriangleMesh build_mesh(const Map& map, const MeshOptions& options, TaskPool* pool, const MapProgress& progress) {
  RASTRO_CHECK(options.voxel_m > 0.0, "voxels have a size");
  DistanceVolume volume(options);
  const SurfaceOptions surface = detail::surface_options(map, 1, options.min_depth_m, options.max_depth_m);
  std::vector<std::vector<SurfaceSample>> group(detail::MapViews::group_size);
  detail::MapViews views(map, detail::keyframes_of(map, options.submap), pool);
  int width = 0, height = 0;
  views.walk(
      [&](std::size_t slot, std::size_t, const UnpackedImages& images, const RayTable& rays) {
        group[slot] = surface_samples(images, rays, surface);
        if (slot == 0) width = rays.width(), height = rays.height();
      },
      [&](std::size_t first, std::size_t count) {
        for (std::size_t slot = 0; slot < count; ++slot) {
          const SE3& pose = map.keyframes[views.keyframes()[first + slot]].world_from_camera;
          volume.add(group[slot], map.cameras.front().intrinsics, width, height, pose, pool);
        }
      },
      progress);
  volume.sort();
  const int min_views = std::min(options.min_views, static_cast<int>(views.keyframes().size()));
  TriangleMesh mesh = SurfaceNet(volume, min_views).make(pool);
  drop_loose_vertices(mesh);
  return mesh;
}

}  // namespace rastro
