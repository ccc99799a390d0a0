// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

enum class LengthKind : std::uint8_t {
  edges,   ///< Between two roughly parallel straight edges, perpendicular to both.
  planes,  ///< Between two roughly parallel faces.
  points,  ///< Between two points of surfaces, or corners.
};
const char* name_of(LengthKind kind);

/// Rough position of one of the two features of a length. Meters.
struct LengthPoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< Rough: on the edge, on the face, or the point itself.
  /// Rough and of unit length: of the edge (one); of the two edges that form a corner (two); else none.
  std::vector<Eigen::Vector3d> directions;
  std::optional<Eigen::Vector3d> normal;  ///< Of the face, planes only; rough, unit length, either sign.
  std::optional<Eigen::Vector3d> face;    ///< Rough point on the flat face that the edge bounds.
};

/// A length to measure in a map.
struct LengthObject {
  std::string name;
  LengthKind kind = LengthKind::edges;
  std::optional<double> true_length_m;
  double radius_m = 0.06;  ///< Maximum error of the rough points.
  LengthPoint a, b;
};

struct LengthObjects {
  /// The points are given in the frame of the ground-truth trajectory, not of the map (that of its first camera).
  bool in_frame_of_ground_truth = false;
  std::vector<LengthObject> objects;
};

/// Parses YAML as described by `rastro measure --help`. Throws Error naming line and key for anything else.
LengthObjects parse_length_objects(std::string_view yaml, std::string_view where);

/// The same object with its points in another frame.
LengthObject moved(const LengthObject& object, const SE3& target_from_source);

}  // namespace rastro
