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
  edges,   ///< Between two about parallel straight edges, at right angles to both.
  planes,  ///< Between two about parallel faces.
  points,  ///< Between two points of surfaces, or corners.
};
const char* name_of(LengthKind kind);

/// Where to look for one of the two features of a length. Metres.
struct LengthSpot {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< Rough: on the edge, on the face, or the point itself.
  /// Rough and of unit length: of the edge (one); of the two edges that meet in a corner (two); else none.
  std::vector<Eigen::Vector3d> directions;
  std::optional<Eigen::Vector3d> normal;  ///< Of the face, planes only; rough, unit length, either sign.
  std::optional<Eigen::Vector3d> face;    ///< Rough spot on the flat face that the edge bounds.
};

/// A length that is to be found in a map.
struct LengthObject {
  std::string name;
  LengthKind kind = LengthKind::edges;
  std::optional<double> true_length_m;
  double radius_m = 0.06;  ///< How far a spot may be off.
  LengthSpot a, b;
};

struct LengthObjects {
  /// The spots are given in the frame of the true trajectory, not in the map's (that of its first camera).
  bool in_frame_of_truth = false;
  std::vector<LengthObject> objects;
};

/// YAML as `rastro measure --help` describes it. Error naming line and key for anything else.
LengthObjects parse_length_objects(std::string_view yaml, std::string_view where);

/// The same object with its spots in another frame.
LengthObject moved(const LengthObject& object, const SE3& target_from_source);

}  // namespace rastro
