// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd/point_map.h"

#include <algorithm>

namespace rastro {
namespace {

// Readings of one spot share most of their error: more than these tell nothing new.
constexpr double most_readings = 4.0;
constexpr int adjustment_iterations = 5;

}  // namespace

void PointMap::add_reading(MapPoint& point, const DepthReading& reading) {
  const double share = 1.0 / (std::min(point.readings, 20.0) + 1.0);
  point.read_inverse_depth += share * (reading.inverse_depth - point.read_inverse_depth);
  point.per_second += share * (reading.per_second - point.per_second);
  point.readings += 1.0;
  point.information = std::min(point.readings, most_readings) / (reading.sigma * reading.sigma);
}

void PointMap::forget(int count, int most_missed) {
  const int oldest = std::max(first_live, static_cast<int>(references.size()) - count);
  std::erase_if(points, [&](const MapPoint& point) { return point.anchor < oldest || point.missed > most_missed; });
}

void PointMap::delay_depths(double seconds) {
  for (MapPoint& point : points) {
    const double change = seconds * point.per_second;
    if (point.inverse_depth + change <= 0.0 || point.read_inverse_depth + change <= 0.0) continue;
    point.inverse_depth += change;
    point.read_inverse_depth += change;
    for (PointSighting& sighting : point.sightings) {
      if (sighting.inverse_depth > 0.0) sighting.inverse_depth += seconds * sighting.per_second;
    }
  }
}

void PointMap::adjust(int window, double ray_sigma, double max_error) {
  const int newest = static_cast<int>(references.size()) - 1;
  const int first_free = std::max(first_live + 1, newest - window + 1);
  if (first_free > newest) return;
  ReferenceWindow problem;
  problem.ray_sigma = ray_sigma;
  std::vector<int> camera_of(references.size(), -1), reference_of;
  const auto camera = [&](int reference) {
    int& index = camera_of[static_cast<std::size_t>(reference)];
    if (index < 0) {
      index = static_cast<int>(problem.world_from_camera.size());
      problem.world_from_camera.push_back(references[static_cast<std::size_t>(reference)].world_from_camera);
      problem.fixed.push_back(reference < first_free ? 1 : 0);
      reference_of.push_back(reference);
    }
    return index;
  };
  std::vector<std::size_t> point_of;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const MapPoint& point = points[i];
    if (point.sightings.empty() || point.sightings.back().reference < first_free) continue;
    for (const PointSighting& sighting : point.sightings) {
      problem.sightings.push_back({camera(sighting.reference), static_cast<int>(problem.points.size()), sighting.ray,
                                   sighting.inverse_depth, sighting.inverse_depth_sigma});
    }
    problem.points.push_back(
        {camera(point.anchor), point.ray, point.inverse_depth, point.read_inverse_depth, point.information});
    point_of.push_back(i);
  }
  for (int i = first_free; i <= newest; ++i) {
    for (const CameraLink& link : references[static_cast<std::size_t>(i)].links)
      problem.links.push_back({camera(link.from), camera(link.to), link.from_from_to, link.information});
  }
  adjust_references(problem, adjustment_iterations);
  for (std::size_t i = 0; i < reference_of.size(); ++i)
    references[static_cast<std::size_t>(reference_of[i])].world_from_camera = problem.world_from_camera[i];
  for (std::size_t i = 0; i < point_of.size(); ++i) {
    MapPoint& point = points[point_of[i]];
    point.inverse_depth = problem.points[i].inverse_depth;
    drop_misfits(point, max_error);
  }
}

void PointMap::drop_misfits(MapPoint& point, double max_error) const {
  const Eigen::Vector3d p_in_world = in_world(point);
  std::erase_if(point.sightings, [&](const PointSighting& sighting) {
    const Eigen::Vector3d p =
        references[static_cast<std::size_t>(sighting.reference)].world_from_camera.inverse() * p_in_world;
    return p.z() <= 0.0 || (p.head<2>() / p.z() - sighting.ray).norm() > max_error;
  });
}

}  // namespace rastro
