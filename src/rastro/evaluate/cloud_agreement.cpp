// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/cloud_agreement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>
#include <vector>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double max_samples = 2e6;
constexpr std::size_t nearest_samples = 8;  ///< Samples whose triangles a point is compared with.
constexpr int grain = 4096;

struct Samples {
  std::vector<Vector3f> at;
  std::vector<std::uint32_t> triangle;  ///< Per sample; empty without triangles.

  // Interface required by nanoflann.
  std::size_t kdtree_get_point_count() const { return at.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t axis) const { return at[index][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Samples>, Samples, 3, std::uint32_t>;

std::array<Vector3f, 3> corners_of(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& of = mesh.triangles[triangle];
  return {mesh.vertices[of[0]].position, mesh.vertices[of[1]].position, mesh.vertices[of[2]].position};
}

double area_of(const std::array<Vector3f, 3>& corners) {
  const Vector3d a = (corners[1] - corners[0]).cast<double>(), b = (corners[2] - corners[0]).cast<double>();
  return 0.5 * a.cross(b).norm();
}

/// Samples all over a triangle: the centers of the pieces from repeatedly halving the longest side.
void cover(const std::array<Vector3f, 3>& corners, std::uint32_t triangle, float spacing, Samples& samples) {
  std::size_t from = 0;
  float longest = 0.0F;
  for (std::size_t k = 0; k < 3; ++k) {
    const float length = (corners[(k + 1) % 3] - corners[k]).squaredNorm();
    if (length > longest) longest = length, from = k;
  }
  // The halves of a piece of this size are about as large as a square of `spacing`.
  if (!(longest > 4.0F * spacing * spacing)) {
    samples.at.push_back((corners[0] + corners[1] + corners[2]) / 3.0F);
    samples.triangle.push_back(triangle);
    return;
  }
  const Vector3f &a = corners[from], &b = corners[(from + 1) % 3], &c = corners[(from + 2) % 3];
  const Vector3f middle = 0.5F * (a + b);
  // Of coordinates as large as those of a country, the middle is one of the ends.
  if (middle == a || middle == b) {
    samples.at.push_back(middle);
    samples.triangle.push_back(triangle);
    return;
  }
  cover({a, middle, c}, triangle, spacing, samples);
  cover({middle, b, c}, triangle, spacing, samples);
}

Samples samples_of(const TriangleMesh& mesh, double spacing) {
  Samples samples;
  if (mesh.triangles.empty()) {
    for (const MeshVertex& vertex : mesh.vertices) samples.at.push_back(vertex.position);
    return samples;
  }
  double area = 0.0, length = 0.0;  // slivers get samples by their length
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto corners = corners_of(mesh, k);
    area += area_of(corners);
    length += static_cast<double>((corners[1] - corners[0]).norm() + (corners[2] - corners[0]).norm());
  }
  spacing = std::max({spacing, std::sqrt(area / max_samples), length / max_samples});
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
    cover(corners_of(mesh, k), static_cast<std::uint32_t>(k), static_cast<float>(spacing), samples);
  return samples;
}

/// Ericson 2005, "Real-Time Collision Detection", 5.1.5.
double distance_to(const Vector3d& p, const std::array<Vector3f, 3>& corners) {
  const Vector3d a = corners[0].cast<double>(), b = corners[1].cast<double>(), c = corners[2].cast<double>();
  const Vector3d normal = (b - a).cross(c - a);
  bool inside = normal.norm() > 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
    const Vector3d side = to - from;
    const double share = side.squaredNorm() > 0.0 ? std::clamp(side.dot(p - from) / side.squaredNorm(), 0.0, 1.0) : 0.0;
    least = std::min(least, (p - from - share * side).norm());
    inside = inside && side.cross(p - from).dot(normal) >= 0.0;
  }
  return inside ? std::abs(normal.dot(p - a)) / normal.norm() : least;
}

double distance_to_ground_truth(const Vector3f& point, const TriangleMesh& mesh, const Samples& samples,
                                const Tree& tree) {
  std::array<std::uint32_t, nearest_samples> found{};
  std::array<float, nearest_samples> squares{};
  const std::size_t wanted = samples.triangle.empty() ? 1 : nearest_samples;
  const std::size_t count = tree.knnSearch(point.data(), wanted, found.data(), squares.data());
  double least = std::sqrt(static_cast<double>(squares[0]));
  if (samples.triangle.empty()) return least;
  for (std::size_t k = 0; k < count; ++k)
    least = std::min(least, distance_to(point.cast<double>(), corners_of(mesh, samples.triangle[found[k]])));
  return least;
}

void for_all(TaskPool* pool, std::size_t count, const std::function<void(std::size_t)>& body) {
  const auto over = [&](int begin, int end) {
    for (int k = begin; k < end; ++k) body(static_cast<std::size_t>(k));
  };
  if (pool == nullptr) return over(0, static_cast<int>(count));
  pool->for_chunks(0, static_cast<int>(count), grain, over);
}

double share_within(const std::vector<double>& distances, double tolerance) {
  const auto within = std::count_if(distances.begin(), distances.end(), [&](double d) { return d <= tolerance; });
  return static_cast<double>(within) / static_cast<double>(distances.size());
}

double root_mean_square(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

CloudAgreement cloud_agreement(const TriangleMesh& ground_truth, const PointCloud& cloud,
                               const CloudAgreementOptions& options, TaskPool* pool) {
  const Samples samples = samples_of(ground_truth, options.spacing_m);
  if (samples.at.empty()) throw Error("the ground truth has no points", "REF", "give a PLY with vertices");
  if (cloud.points.empty()) throw Error("the cloud has no points", "EST", "give a PLY with vertices");
  const Tree tree(3, samples);
  std::vector<double> distances(cloud.points.size());
  for_all(pool, distances.size(), [&](std::size_t k) {
    distances[k] = distance_to_ground_truth(cloud.points[k].position, ground_truth, samples, tree);
  });
  Samples own;
  for (const CloudPoint& point : cloud.points) own.at.push_back(point.position);
  const Tree own_tree(3, own);
  std::vector<double> gaps(samples.at.size());
  for_all(pool, gaps.size(),
          [&](std::size_t k) { gaps[k] = distance_to_ground_truth(samples.at[k], {}, own, own_tree); });

  CloudAgreement agreement;
  std::vector<double> ratios;
  for (std::size_t k = 0; k < distances.size(); ++k)
    if (cloud.points[k].sigma > 0.0F) ratios.push_back(distances[k] / static_cast<double>(cloud.points[k].sigma));
  agreement.points = distances.size();
  agreement.precision = share_within(distances, options.tolerance_m);
  agreement.completeness = share_within(gaps, options.tolerance_m);
  agreement.sigma_ratio = root_mean_square(ratios);
  agreement.rms = root_mean_square(distances);
  agreement.mean = std::accumulate(distances.begin(), distances.end(), 0.0) / static_cast<double>(distances.size());
  std::sort(distances.begin(), distances.end());
  agreement.median = distances[distances.size() / 2];
  agreement.percentile_95 = distances[(distances.size() * 95) / 100];
  agreement.largest = distances.back();
  return agreement;
}

}  // namespace rastro
