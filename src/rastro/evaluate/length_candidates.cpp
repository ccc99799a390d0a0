// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_candidates.h"

#include <Eigen/Dense>
#include <cmath>
#include <optional>

#include "rastro/base/random.h"
#include "rastro/evaluate/length_edge.h"
#include "rastro/evaluate/length_face.h"

namespace rastro {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double shared_px = 0.35;  ///< Light, blur and the surroundings shift an edge equally in all images.

LengthCandidate face_candidate(const LengthView& view, const LengthFace& face, const Vector3d& spot) {
  LengthCandidate found;
  const Vector3d foot = face.foot(spot), normal = face.normal();
  const Vector3d ray = foot / foot.z();
  const double sigma = std::abs(normal.dot(ray)) * face.depth_sigma_at(ray);
  const Matrix3d rotation = view.world_from_camera.rotation().matrix();
  found.point = view.world_from_camera * foot;
  found.direction = rotation * normal;
  found.covariance = sigma * sigma * found.direction * found.direction.transpose();
  found.score = std::sqrt(static_cast<double>(face.points)) * face.support;
  const auto pixel = view.camera.project(foot);
  if (pixel) found.pixels = {*pixel, *pixel};
  return found;
}

std::vector<LengthCandidate> edge_candidates(const LengthView& view, const LengthFace& face,
                                             const LengthEdgeSearch& search) {
  std::vector<LengthCandidate> found;
  const Matrix3d rotation = view.world_from_camera.rotation().matrix();
  for (const LengthEdge& edge : find_edges(view, face, search)) {
    LengthCandidate one;
    one.point = view.world_from_camera * edge.point;
    one.direction = rotation * edge.direction;
    one.covariance = rotation * edge.covariance * rotation.transpose();
    one.score = edge.score;
    one.shared_m = shared_px * edge.pixel_m;
    one.pixels = edge.pixels;
    found.push_back(one);
  }
  return found;
}

/// The face through the given points, for objects without depth.
LengthFace rough_face(const LengthView& view, const LengthFeature& feature) {
  const SE3 camera_from_world = view.world_from_camera.inverse();
  const Vector3d normal = camera_from_world.rotation() * feature.normal();
  const double distance = normal.dot(camera_from_world * feature.spot);
  LengthFace face;
  if (std::abs(distance) > 0.02) face.inverse = normal / distance;
  return face;
}

std::optional<LengthFace> measured_face(const LengthView& view, const LengthFeature& feature, double radius_m,
                                        const MapLengthOptions& options) {
  const SE3 camera_from_world = view.world_from_camera.inverse();
  LengthRegion region = length_region(feature, radius_m, options);
  region.center = camera_from_world * region.center;
  region.axes = camera_from_world.rotation().matrix() * region.axes;
  return find_face(view, region, seed_for(options.seed, static_cast<std::uint64_t>(view.keyframe)));
}

}  // namespace

std::vector<LengthCandidate> length_candidates(const LengthView& view, const LengthFeature& feature, double radius_m,
                                               const MapLengthOptions& options, bool by_depth) {
  const auto face = by_depth ? measured_face(view, feature, radius_m, options) : rough_face(view, feature);
  if (!face || face->inverse.isZero()) return {};
  const SE3 camera_from_world = view.world_from_camera.inverse();
  const Matrix3d rotation = camera_from_world.rotation().matrix();
  const Vector3d spot = camera_from_world * feature.spot;
  std::vector<LengthCandidate> found;
  if (feature.is_edge) {
    found = edge_candidates(
        view, *face, {spot, rotation * feature.along, rotation * feature.inwards, radius_m, options.half_length_m});
  } else {
    found.push_back(face_candidate(view, *face, spot));
  }
  for (LengthCandidate& one : found) {
    one.points = face->points;
    one.support = face->support;
    if (by_depth) continue;
    const Vector3d ray = one.point - view.world_from_camera.translation();
    one.lever = ray / ray.dot(feature.normal());
  }
  return found;
}

}  // namespace rastro
