// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace rastro {

/// Switchable constraints (Suenderhauf and Protzel 2012) with the switch eliminated in closed form (Agarwal et al.
/// 2013, "Robust map optimization using dynamic covariance scaling"): the value of s^2 e + price (1 - s)^2 at the best
/// switch s = price / (price + e). Like the kernels of math/robust_kernel.h, cost() of a squared residual e in sigmas.
struct SwitchKernel {
  double price = 30.0;  ///< Upper bound of the cost.

  double cost(double squared_error) const { return open(squared_error) * squared_error; }
  /// Derivative of cost().
  double weight(double squared_error) const { return open(squared_error) * open(squared_error); }
  /// Derivative of weight().
  double weight_slope(double squared_error) const {
    return -2.0 * open(squared_error) * open(squared_error) / (price + squared_error);
  }

 private:
  double open(double squared_error) const { return price / (price + squared_error); }
};

}  // namespace rastro
