// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/mesh/build_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <map>

#include "rastro/base/error.h"
#include "rastro/map/images/room_map_testing.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

MeshOptions coarse() {
  MeshOptions options;
  options.voxel_m = 0.04;
  return options;
}

double distance_to_room(const Vector3d& point) {
  double least = 1e9;
  for (int axis = 0; axis < 3; ++axis)
    for (const double wall : {test_room::low[axis], test_room::high[axis]})
      least = std::min(least, std::abs(point[axis] - wall));
  const Vector3d outside = (test_room::box_low - point).cwiseMax(point - test_room::box_high);
  const double to_box = outside.maxCoeff() > 0.0 ? outside.cwiseMax(0.0).norm() : -outside.maxCoeff();
  return std::min(least, to_box);
}

TEST(BuildMesh, IsASurfaceWhereTheRoomHasOne) {
  const TriangleMesh mesh = build_mesh(make_test_map(4), coarse());
  ASSERT_GT(mesh.triangles.size(), 2000U);
  std::size_t close = 0;
  for (const MeshVertex& vertex : mesh.vertices) {
    const double distance = distance_to_room(vertex.position.cast<double>());
    EXPECT_LT(distance, 0.05);
    close += distance < 0.005 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(close), 0.9 * static_cast<double>(mesh.vertices.size())) << "away from edges";
}

TEST(BuildMesh, EveryTriangleFacesTheCamerasAndNeighborsShareEdges) {
  const Map map = make_test_map(4);
  const TriangleMesh mesh = build_mesh(map, coarse());
  const Vector3d camera = map.keyframes[1].world_from_camera.translation();
  std::size_t towards = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& triangle : mesh.triangles) {
    std::array<Vector3d, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = mesh.vertices[triangle[k]].position.cast<double>();
      ++edges[{triangle[k], triangle[(k + 1) % 3]}];
    }
    towards += (at[1] - at[0]).cross(at[2] - at[0]).dot(camera - at[0]) > 0.0 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(towards), 0.97 * static_cast<double>(mesh.triangles.size()));
  // A directed edge belongs to one triangle, since neighbors traverse it in opposite directions; where two surfaces
  // pass through one cell they share a vertex.
  std::size_t shared = 0;
  for (const auto& [edge, count] : edges) shared += count > 1 ? 1 : 0;
  EXPECT_LT(static_cast<double>(shared), 0.02 * static_cast<double>(edges.size()));
}

TEST(BuildMesh, NoEdgeHasMoreThanTwoFaces) {
  for (const double voxel_m : {0.02, 0.04, 0.11}) {
    MeshOptions options;
    options.voxel_m = voxel_m;
    const TriangleMesh mesh = build_mesh(make_test_map(4), options);
    ASSERT_GT(mesh.triangles.size(), 500U);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> faces;
    for (const auto& triangle : mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k) ++faces[std::minmax(triangle[k], triangle[(k + 1) % 3])];
    for (const auto& [edge, count] : faces) ASSERT_LE(count, 2) << "voxels of " << voxel_m;
  }
}

TEST(BuildMesh, GivesTheSameMeshForAnyPoolAndAsksForLargerVoxels) {
  const Map map = make_test_map(2);
  const TriangleMesh alone = build_mesh(map, coarse());
  for (const int threads : {2, 8}) {
    TaskPool pool(threads);
    const TriangleMesh mesh = build_mesh(map, coarse(), &pool);
    EXPECT_TRUE(mesh.triangles == alone.triangles);
    ASSERT_EQ(mesh.vertices.size(), alone.vertices.size());
    for (std::size_t k = 0; k < mesh.vertices.size(); ++k)
      ASSERT_EQ(std::memcmp(mesh.vertices[k].position.data(), alone.vertices[k].position.data(), 12), 0);
  }
  MeshOptions few = coarse();
  few.max_blocks = 10;
  EXPECT_THROW(build_mesh(map, few), Error);
  EXPECT_TRUE(build_mesh(Map(), coarse()).triangles.empty());
}

}  // namespace
}  // namespace rastro
