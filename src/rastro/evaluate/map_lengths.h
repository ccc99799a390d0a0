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

/// One picture that shows what was measured, pixels.
struct LengthPicture {
  std::int64_t keyframe = -1;               ///< None where nothing was found in pictures.
  std::array<Eigen::Vector2d, 2> a{}, b{};  ///< The edge, or twice the point; NaN where this keyframe does not show it.
};

/// What a map says of a length.
struct MeasuredLength {
  std::string name;
  LengthKind kind = LengthKind::edges;
  std::optional<double> true_length_m;
  std::optional<double> length_m;  ///< None: not measurable, and `note` says why.
  double sigma_m = 0.0;            ///< Standard deviation: of picture, depth, and the poses of keyframes.
  std::string note;                ///< What makes the measure doubtful; empty where nothing does.
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();  ///< Where they were found, in the map.
  int keyframes_a = 0, keyframes_b = 0, together = 0;                        ///< That show the feature; that show both.
  std::int64_t points = 0;  ///< Depth pixels, or points of the cloud, that carry the faces.
  double support = 0.0;     ///< Share of the pixels looking at the faces whose depth is theirs: low for glass.
  double scatter_m = 0.0;   ///< Of the single keyframes' measures.
  LengthPicture picture;

  std::optional<double> error_m() const {
    if (!length_m || !true_length_m) return std::nullopt;
    return *length_m - *true_length_m;
  }
};

struct MapLengthOptions {
  int views = 12;               ///< Keyframes for each feature, and as many that see both: the nearest and squarest.
  double half_length_m = 0.08;  ///< Of an edge that is looked at, either side of the spot.
  double patch_m = 0.20;  ///< Into the face, from its edge; half of it about a spot on a face, a quarter about a point.
  std::uint64_t seed = 1;  ///< Of the samples drawn when planes are fitted.
};

/// Finds the objects, whose spots are in the map's frame, in the pictures of its keyframes and measures them there: a
/// cloud ends where depth does, which is not where a thing ends. Only keyframes of the first submap are looked at, the
/// others stand in a frame of their own. The same result for any pool. Error where pictures cannot be read.
std::vector<MeasuredLength> measure_lengths(const Map& map, const std::vector<LengthObject>& objects,
                                            const MapLengthOptions& options, TaskPool& pool);

/// The same in a cloud, which has no pictures: an edge is where the points of a face end, which is where depth does,
/// and sigmas are larger for it.
std::vector<MeasuredLength> measure_lengths(const PointCloud& cloud, const std::vector<LengthObject>& objects,
                                            const MapLengthOptions& options);

}  // namespace rastro
