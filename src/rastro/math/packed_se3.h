// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "rastro/math/se3.h"

namespace rastro {

/// The numbers of an SE3 without the padding of its alignment, for lists as long as a run: 56 bytes instead of 64, and
/// none to reach the next multiple of 16. The same pose comes back, to the last bit.
class PackedSE3 {
 public:
  explicit PackedSE3(const SE3& pose) {
    Eigen::Map<Eigen::Vector4d>(numbers_.data()) = pose.rotation().quaternion().coeffs();
    Eigen::Map<Eigen::Vector3d>(numbers_.data() + 4) = pose.translation();
  }
  SE3 pose() const {
    const Eigen::Map<const Eigen::Quaterniond> quaternion(numbers_.data());
    return {SO3::from_unit(quaternion), Eigen::Map<const Eigen::Vector3d>(numbers_.data() + 4)};
  }

 private:
  std::array<double, 7> numbers_;  ///< The quaternion x y z w, then the translation.
};

}  // namespace rastro
