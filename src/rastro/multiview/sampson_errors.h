// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Squared distance of each pair from the epipolar lines of a fundamental matrix, to first order, in the unit of the
/// points (Sampson 1982). `out` holds one number per pair.
inline void sampson_errors(const Eigen::Matrix3f& m, const PointPairs& pairs, float* out) {
  const float f00 = m(0, 0), f01 = m(0, 1), f02 = m(0, 2), f10 = m(1, 0), f11 = m(1, 1), f12 = m(1, 2);
  const float f20 = m(2, 0), f21 = m(2, 1), f22 = m(2, 2);
  const float *ax = pairs.ax.data(), *ay = pairs.ay.data(), *bx = pairs.bx.data(), *by = pairs.by.data();
  for (std::size_t i = 0, count = pairs.size(); i < count; ++i) {
    const float lbx = f00 * ax[i] + f01 * ay[i] + f02, lby = f10 * ax[i] + f11 * ay[i] + f12;
    const float lbz = f20 * ax[i] + f21 * ay[i] + f22;
    const float lax = f00 * bx[i] + f10 * by[i] + f20, lay = f01 * bx[i] + f11 * by[i] + f21;
    const float value = bx[i] * lbx + by[i] * lby + lbz;
    out[i] = value * value / (lbx * lbx + lby * lby + lax * lax + lay * lay + 1e-30F);
  }
}

}  // namespace rastro
