// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "rastro/base/random.h"
#include "rastro/evaluate/length_feature.h"
#include "rastro/evaluate/map_lengths.h"
#include "rastro/math/median.h"
#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int fewest_points = 12;  ///< Of a face.
constexpr int drawn_planes = 100;
constexpr double gate_sigmas = 3.0, smallest_sigma_m = 0.002, largest_sigma_m = 0.005;
constexpr double cos_largest_tilt = 0.8;
constexpr double shared_sigma_m = 0.003;  ///< Error common to all points of a face.
constexpr double depth_edge_m = 0.012;    ///< Distance between the end of an object and of its depth.
constexpr int fewest_slices = 4;

/// A face of a cloud, and the points on it in the axes of the search region.
struct CloudFace {
  Vector3d normal = Vector3d::Zero(), middle = Vector3d::Zero();
  double sigma_m = 0.0;  ///< Of its position along the normal.
  std::vector<Vector3d> points;

  Vector3d foot(const Vector3d& point) const { return point - normal.dot(point - middle) * normal; }
};

/// One end of a length.
struct CloudEnd {
  std::string problem;  ///< Why it was not found; empty if it was.
  Vector3d point = Vector3d::Zero(), direction = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();
  int points = 0;
};

struct Sample {
  Vector3d point;
  double sigma;
};

std::vector<Sample> samples_in(const PointCloud& cloud, const LengthRegion& region) {
  std::vector<Sample> found;
  for (const CloudPoint& one : cloud.points) {
    const Vector3d point = one.position.cast<double>();
    const Vector3d along = region.axes.transpose() * (point - region.center);
    if ((along.array() >= region.low.array()).all() && (along.array() <= region.high.array()).all())
      found.push_back({point, std::clamp(static_cast<double>(one.sigma), smallest_sigma_m, largest_sigma_m)});
  }
  return found;
}

bool agrees(const Sample& one, const Vector3d& normal, const Vector3d& middle) {
  return std::abs(normal.dot(one.point - middle)) < gate_sigmas * one.sigma;
}

std::optional<CloudFace> drawn_face(const std::vector<Sample>& all, const LengthRegion& region, Random& random) {
  std::optional<CloudFace> best;
  std::ptrdiff_t most = fewest_points - 1;
  const auto count = static_cast<std::uint32_t>(all.size());
  for (int draw = 0; draw < drawn_planes; ++draw) {
    const Vector3d &a = all[random.below(count)].point, &b = all[random.below(count)].point,
                   &c = all[random.below(count)].point;
    const Vector3d cross = (b - a).cross(c - a);
    if (cross.norm() < 1e-6) continue;
    const Vector3d normal = cross.normalized();
    if (region.normal_known && std::abs(normal.dot(region.axes.col(2))) < cos_largest_tilt) continue;
    const auto agree = std::count_if(all.begin(), all.end(), [&](const Sample& one) { return agrees(one, normal, a); });
    if (agree <= most) continue;
    most = agree;
    best = CloudFace{normal, a, 0.0, {}};
  }
  return best;
}

/// Principal axes of the points on it, twice.
void refine(const std::vector<Sample>& all, const LengthRegion& region, CloudFace& face) {
  double squares = 0.0;
  for (int round = 0; round < 3; ++round) {
    std::vector<const Sample*> on;
    for (const Sample& one : all)
      if (agrees(one, face.normal, face.middle)) on.push_back(&one);
    const double share = 1.0 / std::max<double>(1.0, static_cast<double>(on.size()));
    face.middle.setZero();
    for (const Sample* one : on) face.middle += share * one->point;
    Matrix3d scatter = Matrix3d::Zero();
    for (const Sample* one : on) scatter += share * (one->point - face.middle) * (one->point - face.middle).transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter);
    const Vector3d before = face.normal;
    face.normal = solver.eigenvectors().col(0);
    if (face.normal.dot(before) < 0.0) face.normal = -face.normal;
    squares = solver.eigenvalues()[0];
    face.points.clear();
    for (const Sample* one : on) face.points.push_back(region.axes.transpose() * (one->point - region.center));
  }
  const double count = std::max<double>(1.0, static_cast<double>(face.points.size()));
  face.sigma_m = std::sqrt(squares / std::max(1.0, count / 4.0) + shared_sigma_m * shared_sigma_m);
}

std::optional<CloudFace> face_in(const PointCloud& cloud, const LengthRegion& region, std::uint64_t seed) {
  const std::vector<Sample> all = samples_in(cloud, region);
  if (static_cast<int>(all.size()) < fewest_points) return std::nullopt;
  Random random(seed);
  auto face = drawn_face(all, region, random);
  if (face) refine(all, region, *face);
  if (!face || static_cast<int>(face->points.size()) < fewest_points) return std::nullopt;
  return face;
}

/// End of the points of a slice towards the outside (larger values are inside): walks outwards from the inner side
/// until two steps have no point. nullopt if there is none at the start.
std::optional<double> end_of(std::vector<double> positions, double step, double start) {
  std::sort(positions.begin(), positions.end(), std::greater<>());
  std::optional<double> last;
  for (const double position : positions) {
    if (position > start) continue;
    if (last.value_or(start) - position > 2.0 * step) break;
    last = position;
  }
  return last;
}

/// End of the face, along the inward axis from the rough point, with its standard deviation.
std::optional<std::pair<double, double>> boundary(const CloudFace& face, const LengthRegion& region, double spacing) {
  const double width = std::max(2.0 * spacing, 0.01);
  const int slices = static_cast<int>((region.high.x() - region.low.x()) / width);
  std::vector<double> ends;
  for (int k = 0; k < slices; ++k) {
    const double from = region.low.x() + k * width;
    std::vector<double> positions;
    for (const Vector3d& point : face.points)
      if (point.x() >= from && point.x() < from + width) positions.push_back(point.y());
    const auto end = end_of(std::move(positions), spacing, 0.5 * region.high.y());
    if (end) ends.push_back(*end);
  }
  if (static_cast<int>(ends.size()) < fewest_slices) return std::nullopt;
  const double middle = upper_median(ends);
  for (double& end : ends) end = std::abs(end - middle);
  const double spread = 1.4826 * upper_median(ends);
  // The last voxel is filled in part; its point is in the middle of the filled part.
  const double sigma = std::hypot(spread / std::sqrt(static_cast<double>(ends.size())), 0.3 * spacing);
  return std::pair(middle - 0.25 * spacing, std::hypot(sigma, depth_edge_m));
}

CloudEnd edge_end(const CloudFace& face, const LengthFeature& feature, const LengthRegion& region, double spacing) {
  CloudEnd end;
  const auto found = boundary(face, region, spacing);
  if (!found) return {"too few points on its face", {}, {}, {}, 0};
  if (found->first < region.low.y() + 1.5 * spacing)
    return {"the face goes on beyond the edge, and a cloud has no images", {}, {}, {}, 0};
  end.point = face.foot(feature.spot + found->first * feature.inwards);
  end.direction = feature.along;
  end.covariance = std::pow(found->second, 2) * feature.inwards * feature.inwards.transpose() +
                   std::pow(face.sigma_m, 2) * face.normal * face.normal.transpose();
  return end;
}

CloudEnd face_end(const CloudFace& face, const Vector3d& spot) {
  CloudEnd end;
  end.point = face.foot(spot);
  end.direction = face.normal;
  end.covariance = std::pow(face.sigma_m, 2) * face.normal * face.normal.transpose();
  return end;
}

/// Side of a square with one point of the face on average.
double spacing_of(const PointCloud& cloud, const CloudFace& face, const LengthRegion& region) {
  const Vector3d size = region.high - region.low;
  const double measured = std::sqrt(size.x() * size.y() / static_cast<double>(face.points.size()));
  return std::max(cloud.voxel_m, std::min(measured, 0.05));
}

CloudEnd crossing(const CloudEnd& one, const CloudEnd& other) {
  CloudEnd corner = one;
  const double cosine = one.direction.dot(other.direction), sine_squared = std::max(0.04, 1.0 - cosine * cosine);
  const Vector3d between = other.point - one.point;
  corner.point += (between.dot(one.direction) - cosine * between.dot(other.direction)) / sine_squared * one.direction;
  corner.covariance += other.covariance;
  return corner;
}

CloudEnd end_in(const PointCloud& cloud, const LengthObject& object, const LengthPoint& spot,
                const MapLengthOptions& options) {
  std::vector<CloudEnd> ends;
  for (const LengthFeature& feature : length_features(object, spot, options)) {
    LengthRegion region = length_region(feature, object.radius_m, options);
    if (feature.is_edge) region.low.y() = -object.radius_m;
    const auto face = face_in(cloud, region, options.seed);
    if (!face) return {"no face found there", {}, {}, {}, 0};
    ends.push_back(feature.is_edge ? edge_end(*face, feature, region, spacing_of(cloud, *face, region))
                                   : face_end(*face, feature.spot));
    ends.back().points = static_cast<int>(face->points.size());
    if (!ends.back().problem.empty()) return ends.back();
  }
  return ends.size() == 1 ? ends.front() : crossing(ends[0], ends[1]);
}

Vector3d measured_direction(LengthKind kind, const CloudEnd& a, const CloudEnd& b) {
  const Vector3d between = b.point - a.point;
  if (kind == LengthKind::points) return between.normalized();
  const double sign = a.direction.dot(b.direction) < 0.0 ? -1.0 : 1.0;
  const Vector3d axis = (a.direction + sign * b.direction).normalized();
  const double along = between.dot(axis);
  return (kind == LengthKind::edges ? Vector3d(between - along * axis) : Vector3d(along * axis)).normalized();
}

MeasuredLength measured_in(const PointCloud& cloud, const LengthObject& object, const MapLengthOptions& options) {
  const CloudEnd a = end_in(cloud, object, object.a, options), b = end_in(cloud, object, object.b, options);
  if (!a.problem.empty()) return not_measured(object, "a: " + a.problem);
  if (!b.problem.empty()) return not_measured(object, "b: " + b.problem);
  const Vector3d direction = measured_direction(object.kind, a, b);
  MeasuredLength measured = not_measured(object, "");
  measured.length_m = direction.dot(b.point - a.point);
  measured.sigma_m =
      std::sqrt(direction.dot((a.covariance + b.covariance) * direction) + shared_sigma_m * shared_sigma_m);
  measured.a = a.point;
  measured.b = b.point;
  measured.direction = direction;
  measured.points = a.points + b.points;
  return measured;
}

}  // namespace

std::vector<MeasuredLength> measure_lengths(const PointCloud& cloud, const std::vector<LengthObject>& objects,
                                            const MapLengthOptions& options) {
  std::vector<MeasuredLength> measured;
  for (const LengthObject& object : objects) measured.push_back(measured_in(cloud, object, options));
  return measured;
}

}  // namespace rastro
