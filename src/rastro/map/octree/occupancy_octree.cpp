// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/octree/occupancy_octree.h"

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <sstream>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/map/images/map_views.h"
#include "rastro/map/octree/ray_cells.h"

namespace rastro {

struct OccupancyOctree::Tree {
  explicit Tree(std::unique_ptr<octomap::OcTree> tree) : octomap(std::move(tree)) {}
  std::unique_ptr<octomap::OcTree> octomap;
};

namespace {

using detail::CellKey;
using detail::RayCells;

constexpr double no_range_limit_m = 100.0;

octomap::OcTreeKey key_of(CellKey key) {
  return {static_cast<octomap::key_type>(key), static_cast<octomap::key_type>(key >> 16),
          static_cast<octomap::key_type>(key >> 32)};
}

RayCells cells_of(const std::vector<SurfaceSample>& samples, const SE3& world_from_camera,
                  const OctreeOptions& options) {
  RayCells cells(world_from_camera.translation(), options.resolution_m);
  for (const SurfaceSample& sample : samples) {
    const double range = static_cast<double>(sample.point_in_camera.norm());
    const bool hit = range <= options.max_range_m;
    const double share = hit ? 1.0 : options.max_range_m / range;
    cells.add(world_from_camera * (share * sample.point_in_camera.cast<double>()), hit);
  }
  cells.finish();
  return cells;
}

void update(octomap::OcTree& tree, const RayCells& cells) {
  for (const CellKey key : cells.free()) tree.updateNode(key_of(key), false, true);
  for (const CellKey key : cells.hits()) tree.updateNode(key_of(key), true, true);
}

std::string head_of(const octomap::OcTree& tree, const char* format) {
  return fmt::format(
      "{}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n# written by rastro, "
      "meters\nid OcTree\nsize {}\nres {:g}\ndata\n",
      format, tree.size(), tree.getResolution());
}

std::size_t count_leaves(const octomap::OcTree& tree, bool occupied) {
  std::size_t count = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf)
    if (tree.isNodeOccupied(*leaf) == occupied) ++count;
  return count;
}

}  // namespace

OccupancyOctree::OccupancyOctree(std::unique_ptr<Tree> tree) : tree_(std::move(tree)) {}
OccupancyOctree::OccupancyOctree(OccupancyOctree&& other) noexcept = default;
OccupancyOctree& OccupancyOctree::operator=(OccupancyOctree&& other) noexcept = default;
OccupancyOctree::~OccupancyOctree() = default;

double OccupancyOctree::resolution_m() const { return tree_->octomap->getResolution(); }

std::optional<double> OccupancyOctree::occupancy_at(const Eigen::Vector3d& position) const {
  // OctoMap converts any coordinate to an int before it checks the range.
  const double reach = tree_->octomap->getResolution() * 32768.0;
  if (!(position.array().abs() < reach).all()) return std::nullopt;
  octomap::OcTreeKey key;
  if (!tree_->octomap->coordToKeyChecked(position.x(), position.y(), position.z(), key)) return std::nullopt;
  const octomap::OcTreeNode* node = tree_->octomap->search(key);
  if (node == nullptr) return std::nullopt;
  return node->getOccupancy();
}

Eigen::Vector3d OccupancyOctree::low() const {
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  if (tree_->octomap->size() > 0) std::as_const(*tree_->octomap).getMetricMin(corner.x(), corner.y(), corner.z());
  return corner;
}

Eigen::Vector3d OccupancyOctree::high() const {
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  if (tree_->octomap->size() > 0) std::as_const(*tree_->octomap).getMetricMax(corner.x(), corner.y(), corner.z());
  return corner;
}

std::size_t OccupancyOctree::occupied_leaves() const { return count_leaves(*tree_->octomap, true); }
std::size_t OccupancyOctree::free_leaves() const { return count_leaves(*tree_->octomap, false); }

std::vector<OctreeCube> OccupancyOctree::occupied_cubes() const {
  const octomap::OcTree& tree = *tree_->octomap;
  std::vector<OctreeCube> cubes;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf)
    if (tree.isNodeOccupied(*leaf)) cubes.push_back({{leaf.getX(), leaf.getY(), leaf.getZ()}, leaf.getSize()});
  return cubes;
}

// The headers are written here, because OctoMap's own functions print.
std::string OccupancyOctree::ot_bytes() const {
  std::ostringstream stream;
  stream << head_of(*tree_->octomap, "# Octomap OcTree file");
  tree_->octomap->writeData(stream);
  return stream.str();
}

std::string OccupancyOctree::bt_bytes() const {
  octomap::OcTree decided(*tree_->octomap);
  decided.toMaxLikelihood();
  decided.prune();
  std::ostringstream stream;
  stream << head_of(decided, "# Octomap OcTree binary file");
  decided.writeBinaryData(stream);
  return stream.str();
}

OccupancyOctree build_octree(const Map& map, const OctreeOptions& options, TaskPool* pool,
                             const MapProgress& progress) {
  RASTRO_CHECK(options.resolution_m > 0.0, "cubes have a size");
  auto tree = std::make_unique<octomap::OcTree>(options.resolution_m);
  tree->setProbHit(options.hit);
  tree->setProbMiss(options.miss);
  tree->setClampingThresMin(options.lowest);
  tree->setClampingThresMax(options.highest);
  const SurfaceOptions surface = detail::surface_options(map, options.stride, options.min_depth_m, no_range_limit_m);
  std::vector<RayCells> group(detail::MapViews::group_size, RayCells(Eigen::Vector3d::Zero(), options.resolution_m));
  detail::MapViews views(map, detail::keyframes_of(map, options.submap), pool);
  views.walk(
      [&](std::size_t slot, std::size_t keyframe, const UnpackedImages& images, const RayTable& rays) {
        group[slot] =
            cells_of(surface_samples(images, rays, surface), map.keyframes[keyframe].world_from_camera, options);
      },
      [&](std::size_t, std::size_t count) {
        for (std::size_t slot = 0; slot < count; ++slot) update(*tree, group[slot]);
      },
      progress);
  tree->updateInnerOccupancy();
  tree->prune();
  return OccupancyOctree(std::make_unique<OccupancyOctree::Tree>(std::move(tree)));
}

}  // namespace rastro
