// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/variance_factor.h"

namespace rastro {

void VarianceFactor::add(double squared_sigmas, double redundancy) {
  if (!(redundancy > 0.0)) return;
  squared_ += squared_sigmas;
  redundancy_ += redundancy;
}

double VarianceFactor::value() const {
  constexpr double assumed = 60.0;  // redundancy that the assumption counts for: ten constraints
  constexpr double shared = 2.5;
  return shared * (assumed + squared_) / (assumed + redundancy_);
}

}  // namespace rastro
