// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/landmark_finder.h"

#include "rastro/image/box_sum.h"

namespace rastro {
namespace {

constexpr int patch_px = 32;
constexpr int smoothing_radius = 2;
constexpr int angle_radius = 15;
constexpr int most_distance = 64;  // of 256
constexpr int least_lead = 8;      // to the second nearest

}  // namespace

LandmarkFinder::LandmarkFinder() : brief_(patch_px, 1) {}

std::vector<Descriptor> LandmarkFinder::describe(const Pyramid& pyramid, const std::vector<Eigen::Vector2f>& corners) {
  std::vector<Descriptor> descriptors;
  const PaddedImage& image = pyramid.level(0);
  if (corners.empty()) return descriptors;
  box_sums(image, smoothing_radius, sums_);
  for (const Eigen::Vector2f& corner : corners) {
    const double angle = intensity_centroid_angle(image.view(), corner.x(), corner.y(), angle_radius);
    descriptors.push_back(brief_.describe(sums_, corner.x(), corner.y(), angle, 1.0));
  }
  return descriptors;
}

std::vector<FoundPoint> LandmarkFinder::find(const PointMap& map, const Camera& camera, const Pyramid& pyramid,
                                             const std::vector<Eigen::Vector2f>& corners) {
  const std::vector<Descriptor> descriptors = describe(pyramid, corners);
  std::vector<FoundPoint> found;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    int nearest = 256, second = 256;
    std::size_t best = 0;
    for (std::size_t k = 0; k < map.points.size(); ++k) {
      const int distance = hamming_distance(map.points[k].descriptor, descriptors[i]);
      if (distance < nearest) {
        second = nearest;
        nearest = distance;
        best = k;
      } else if (distance < second) {
        second = distance;
      }
    }
    if (nearest > most_distance || second - nearest < least_lead) continue;
    if (const auto ray = camera.unproject(corners[i].cast<double>())) found.push_back({best, corners[i], *ray, false});
  }
  return found;
}

}  // namespace rastro
