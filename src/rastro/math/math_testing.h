// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/math/se3.h"

/// For tests only: matchers and random values of math/.
namespace rastro::testing {

/// A vector whose coefficients are uniform in -size to size.
template <typename Vector>
Vector random_vector(Random& random, double size) {
  Vector result;
  for (auto& value : result) value = random.uniform(-size, size);
  return result;
}

/// Within `meters` in translation and `radians` in rotation of `expected`.
MATCHER_P3(pose_near, expected, meters, radians, "is a pose near the expected one") {
  const double distance = (arg.translation() - expected.translation()).norm();
  const double angle = (expected.rotation().inverse() * arg.rotation()).log().norm();
  *result_listener << "error " << distance << " m and " << angle << " rad";
  return distance <= meters && angle <= radians;
}

/// Every coefficient within `tolerance` of the expected matrix's; NaN never is.
MATCHER_P2(matrix_near, expected, tolerance, "is a matrix near the expected one") {
  if (arg.rows() != expected.rows() || arg.cols() != expected.cols()) return false;
  const double error = (arg - expected).cwiseAbs().maxCoeff();
  *result_listener << "error up to " << error;
  return error <= tolerance && arg.allFinite();
}

}  // namespace rastro::testing
