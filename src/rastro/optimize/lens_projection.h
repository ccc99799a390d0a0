// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
// Projection by any of the lens models, for numbers and for the jets of Ceres.
#pragma once

#include <cmath>

#include "rastro/optimize/lens.h"

namespace rastro {

constexpr int lens_size(LensModel model) {
  return model == LensModel::pinhole_8 ? 12 : model == LensModel::pinhole_5 ? 9 : 8;
}

/// (x, y) = point / z as the equidistant model images it.
template <typename T>
void distort_equidistant(const T* k, T& x, T& y) {
  using std::atan2;
  using std::sqrt;
  const T rr = x * x + y * y;
  if (rr < T(1e-20)) return;
  const T r = sqrt(rr), angle = atan2(r, T(1.0)), s = angle * angle;
  const T scale = angle * (T(1.0) + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])))) / r;
  x *= scale;
  y *= scale;
}

template <typename T>
void distort_brown(const T* k, int count, T& x, T& y) {
  const T rr = x * x + y * y, xy = x * y;
  T radial = T(1.0) + rr * (k[0] + rr * (k[1] + (count > 4 ? rr * k[4] : T(0.0))));
  if (count == 8) radial = radial / (T(1.0) + rr * (k[5] + rr * (k[6] + rr * k[7])));
  const T distorted_x = x * radial + T(2.0) * k[2] * xy + k[3] * (rr + T(2.0) * x * x);
  y = y * radial + k[2] * (rr + T(2.0) * y * y) + T(2.0) * k[3] * xy;
  x = distorted_x;
}

/// False for points that are not in front of the camera.
template <LensModel model, typename T>
bool project_by(const T* parameters, const T* point, T* pixel) {
  if (!(point[2] > T(1e-9))) return false;
  T x = point[0] / point[2], y = point[1] / point[2];
  if constexpr (model == LensModel::equidistant) {
    distort_equidistant(parameters + 4, x, y);
  } else {
    distort_brown(parameters + 4, lens_size(model) - 4, x, y);
  }
  pixel[0] = parameters[0] * x + parameters[2];
  pixel[1] = parameters[1] * y + parameters[3];
  return true;
}

/// Calls `function` with the model as a template argument.
template <typename Function>
auto with_model(LensModel model, const Function& function) {
  switch (model) {
    case LensModel::pinhole_5:
      return function.template operator()<LensModel::pinhole_5>();
    case LensModel::pinhole_8:
      return function.template operator()<LensModel::pinhole_8>();
    case LensModel::equidistant:
      return function.template operator()<LensModel::equidistant>();
    case LensModel::pinhole_4:
      break;
  }
  return function.template operator()<LensModel::pinhole_4>();
}

}  // namespace rastro
