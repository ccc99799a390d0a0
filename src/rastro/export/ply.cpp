// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/ply.h"

#include <fmt/format.h>

#include <limits>

#include "rastro/base/text.h"
#include "rastro/export/raw_bytes.h"

namespace rastro {
namespace {

using detail::append_raw;

constexpr std::size_t bytes_a_point = 35;
constexpr const char* position_properties =
    "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\n";

std::string head(const std::string& frame, const std::string& unit) {
  return fmt::format("ply\nformat binary_little_endian 1.0\ncomment written by rastro; lengths in {}; {}\n", unit,
                     one_line(frame));
}

float known_sigma(const CloudPoint& point) {
  return point.sigma > 0.0F ? point.sigma : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

std::string cloud_ply(const PointCloud& cloud, const std::string& frame, const CloudTerms& terms) {
  std::string bytes;
  bytes.reserve(1000 + bytes_a_point * cloud.points.size());
  cloud_ply(cloud, frame, terms, [&bytes](std::string_view piece) { bytes += piece; });
  return bytes;
}

void cloud_ply(const PointCloud& cloud, const std::string& frame, const CloudTerms& terms,
               const std::function<void(std::string_view)>& put) {
  constexpr std::size_t piece_bytes = 1 << 18;
  std::string bytes = head(frame, terms.unit);
  if (cloud.voxel_m > 0.0) bytes += fmt::format("comment one point a voxel of {:g} m\n", cloud.voxel_m);
  bytes += fmt::format("comment count: {}; sigma: standard deviation of {}, {}; nan: unknown\n", terms.count,
                       terms.sigma, terms.unit);
  bytes += fmt::format("element vertex {}\n{}property uint count\nproperty float sigma\nend_header\n",
                       cloud.points.size(), position_properties);
  for (const CloudPoint& point : cloud.points) {
    append_raw(bytes, point.position);
    append_raw(bytes, point.normal);
    append_raw(bytes, point.color);
    append_raw(bytes, point.count);
    append_raw(bytes, known_sigma(point));
    if (bytes.size() < piece_bytes) continue;
    put(bytes);
    bytes.clear();
  }
  put(bytes);
}

std::string mesh_ply(const TriangleMesh& mesh, const std::string& frame) {
  std::string bytes = head(frame, "meters");
  bytes += fmt::format("element vertex {}\n{}element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                       mesh.vertices.size(), position_properties, mesh.triangles.size());
  for (const MeshVertex& vertex : mesh.vertices) {
    append_raw(bytes, vertex.position);
    append_raw(bytes, vertex.normal);
    append_raw(bytes, vertex.color);
  }
  for (const auto& triangle : mesh.triangles) {
    bytes += '\3';
    append_raw(bytes, triangle);
  }
  return bytes;
}

}  // namespace rastro
