// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/evaluate/length_objects.h"
#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// One image that shows what was measured, pixels.
struct LengthImage {
  std::int64_t keyframe = -1;               ///< -1 if nothing was detected in images.
  std::array<Eigen::Vector2d, 2> a{}, b{};  ///< The edge, or twice the point; NaN if this keyframe does not show it.
};

/// Result of measuring one length in a map.
struct MeasuredLength {
  std::string name;
  LengthKind kind = LengthKind::edges;
  std::optional<double> true_length_m;
  std::optional<double> length_m;  ///< None: not measurable, and `note` says why.
  double sigma_m = 0.0;            ///< Standard deviation: from image, depth, and keyframe poses.
  std::string note;                ///< Doubts about the measurement; empty without any.
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();  ///< Their measured positions, in the map.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< Unit, from a to b: along which the length is measured.
  int keyframes_a = 0, keyframes_b = 0, together = 0;   ///< Number that show the feature; that show both.
  std::int64_t points = 0;                              ///< Depth pixels, or points of the cloud, on the faces.
  double support = 0.0;    ///< Share of the pixels facing the faces with their depth: low for glass.
  double scatter_m = 0.0;  ///< Scatter of the single keyframes' measurements.
  LengthImage image;

  std::optional<double> error_m() const {
    if (!length_m || !true_length_m) return std::nullopt;
    return *length_m - *true_length_m;
  }
};

struct MapLengthOptions {
  int views = 12;  ///< Keyframes for each feature, and as many that show both: the closest and most frontal.
  double half_length_m = 0.08;  ///< Length of the edge used, on either side of the rough point.
  double patch_m = 0.20;   ///< Into the face, from its edge; half of it around a point on a face, a quarter around a
                           ///< corner or surface point.
  std::uint64_t seed = 1;  ///< For RANSAC of planes.
};

/// Detects the objects, whose rough points are in the map's frame, in the images of the map's keyframes and measures
/// them there: the points of a cloud do not end where an object ends. Uses only keyframes of the first submap, because
/// disconnected ones have their own frames. The same result for any pool. Throws Error if images cannot be read.
std::vector<MeasuredLength> measure_lengths(const Map& map, const std::vector<LengthObject>& objects,
                                            const MapLengthOptions& options, TaskPool& pool);

/// The same in a cloud, which has no images: an edge is where the points of a face end. Sigmas are larger for it.
std::vector<MeasuredLength> measure_lengths(const PointCloud& cloud, const std::vector<LengthObject>& objects,
                                            const MapLengthOptions& options);

}  // namespace rastro
