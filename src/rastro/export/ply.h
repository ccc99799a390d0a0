// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/mesh/triangle_mesh.h"

namespace rastro {

/// What the numbers of a cloud mean, for the comments of its file.
struct CloudTerms {
  std::string unit = "meters";                          ///< Of all lengths.
  std::string count = "measurements";                   ///< What `count` counts.
  std::string sigma = "the position along the normal";  ///< What `sigma` is the standard deviation of.
};

/// Binary PLY: x y z nx ny nz (float), red green blue (uchar), count (uint), sigma (float; nan: unknown). `frame`
/// says in a comment what the coordinates are of.
std::string cloud_ply(const PointCloud& cloud, const std::string& frame, const CloudTerms& terms = {});
/// The same in pieces: as a whole it is as large as the cloud.
void cloud_ply(const PointCloud& cloud, const std::string& frame, const CloudTerms& terms,
               const std::function<void(std::string_view)>& put);
std::string mesh_ply(const TriangleMesh& mesh, const std::string& frame);

/// Reads the vertices of a PLY, text or binary of either byte order, from whatever program: x, y, z are needed;
/// normals, colors, count and sigma are taken where they are. Points that are not finite are omitted; a normal that is
/// not is unknown. Error naming `where` for what is not a PLY or ends early.
PointCloud parse_cloud_ply(std::string_view bytes, const std::string& where);
/// The same with faces; polygons are cut into triangles.
TriangleMesh parse_mesh_ply(std::string_view bytes, const std::string& where);

PointCloud read_cloud_ply(const std::string& file);
TriangleMesh read_mesh_ply(const std::string& file);

}  // namespace rastro
