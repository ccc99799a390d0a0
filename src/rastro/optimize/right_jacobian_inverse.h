// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/LU>

#include "rastro/math/lie.h"

namespace rastro {

/// Derivative of log() of a group element by a small step on its right. For small residuals faster than the inverse of
/// right_jacobian().
template <typename Group>
auto right_jacobian_inverse(const typename Group::Tangent& tangent) {
  using Matrix = decltype(Group::small_adjoint(tangent));
  const Matrix bracket = Group::small_adjoint(tangent);
  // The Bernoulli series, exact to 1e-9 for such small residuals.
  if (tangent.squaredNorm() < 0.01) {
    const Matrix square = bracket * bracket;
    return Matrix(Matrix::Identity() + 0.5 * bracket + square / 12.0 - square * square / 720.0);
  }
  return Matrix(right_jacobian<Group>(tangent).inverse());
}

}  // namespace rastro
