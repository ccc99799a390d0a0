// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/epipolar_kernels.h"

#include <cstddef>
#include <limits>

#include "rastro/base/simd.h"
#include "rastro/slam/lsd/depth/epipolar_search.h"
#include "rastro/slam/lsd/one_lane.h"

namespace rastro {
namespace epipolar_one_lane {
namespace {

namespace lanes = one_lane;
#define RASTRO_LANES inline
#define RASTRO_LANES_LAMBDA
#define RASTRO_LANES_TARGET
#include "rastro/slam/lsd/depth/epipolar_lanes.inc"
#undef RASTRO_LANES
#undef RASTRO_LANES_LAMBDA
#undef RASTRO_LANES_TARGET

}  // namespace
}  // namespace epipolar_one_lane

const EpipolarKernels& epipolar_kernels_plain() {
  static const EpipolarKernels kernels{epipolar_one_lane::search_all};
  return kernels;
}

const EpipolarKernels& epipolar_kernels() {
  return simd_level() == SimdLevel::avx2 ? epipolar_kernels_avx2() : epipolar_kernels_plain();
}

}  // namespace rastro
