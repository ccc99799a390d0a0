// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

namespace rastro {

/// A straight edge of an object in a generated world, as the end of a length.
struct NamedEdge {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< In the world, meters.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
};

/// A length that is known exactly: the distance between two parallel edges of a flat face.
struct NamedLength {
  std::string name;
  double length_m = 0.0;
  NamedEdge a, b;
  Eigen::Vector3d face = Eigen::Vector3d::Zero();  ///< A point on the face that both bound.
};

}  // namespace rastro
