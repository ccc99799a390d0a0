// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace rastro {

/// Robust kernels: cost(squared_error) grows as squared_error itself for small errors and slower beyond `width` (in the
/// unit of the error); weight() is its derivative, the factor of that residual in iteratively reweighted least squares.
/// Zhang 1997, "Parameter estimation techniques".
struct HuberKernel {
  double width = 1.345;  ///< 95 % efficiency for normal errors of standard deviation 1.

  double cost(double squared_error) const {
    if (squared_error <= width * width) return squared_error;
    return 2.0 * width * std::sqrt(squared_error) - width * width;
  }
  double weight(double squared_error) const {
    return squared_error <= width * width ? 1.0 : width / std::sqrt(squared_error);
  }
};

/// Never rejects an error completely, but gives large ones ever less weight.
struct CauchyKernel {
  double width = 2.3849;

  double cost(double squared_error) const { return width * width * std::log1p(squared_error / (width * width)); }
  double weight(double squared_error) const { return 1.0 / (1.0 + squared_error / (width * width)); }
};

/// Ignores errors beyond `width`: needs a good initial guess.
struct TukeyKernel {
  double width = 4.6851;

  double cost(double squared_error) const {
    const double rest = inside(squared_error);
    return width * width / 3.0 * (1.0 - rest * rest * rest);
  }
  double weight(double squared_error) const {
    const double rest = inside(squared_error);
    return rest * rest;
  }

 private:
  double inside(double squared_error) const {
    const double rest = 1.0 - squared_error / (width * width);
    return rest > 0.0 ? rest : 0.0;
  }
};

}  // namespace rastro
