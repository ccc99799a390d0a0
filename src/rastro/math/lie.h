// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace rastro {

/// For any group here: exp(tangent + d) = exp(tangent) * exp(right_jacobian<Group>(tangent) * d) to first order in d.
/// The power series of the small adjoint (Sola et al. 2018, eq. 41 and 143): converges for every tangent vector, in
/// about 20 terms for rotations up to pi. Where speed matters use the closed form of SO3.
template <typename Group>
auto right_jacobian(const typename Group::Tangent& tangent) {
  using Matrix = decltype(Group::small_adjoint(tangent));
  const Matrix bracket = -Group::small_adjoint(tangent);
  Matrix sum = Matrix::Identity(), term = Matrix::Identity();
  for (int k = 2; k < 200; ++k) {
    term = (term * bracket / k).eval();
    sum += term;
    if (!(term.cwiseAbs().maxCoeff() > 1e-17 * sum.cwiseAbs().maxCoeff())) break;
  }
  return sum;
}

/// exp(tangent + d) = exp(left_jacobian<Group>(tangent) * d) * exp(tangent) to first order in d.
template <typename Group>
auto left_jacobian(const typename Group::Tangent& tangent) {
  return right_jacobian<Group>(-tangent);
}

}  // namespace rastro
