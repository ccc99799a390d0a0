// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_kernels.h"

#include <algorithm>
#include <bit>

#include "rastro/base/simd.h"
#include "rastro/slam/lsd/one_lane.h"

namespace rastro {
namespace depth_one_lane {
namespace {

namespace lanes = one_lane;
#define RASTRO_LANES inline
#define RASTRO_LANES_TARGET
#include "rastro/slam/lsd/depth/depth_lanes.inc"
#undef RASTRO_LANES
#undef RASTRO_LANES_TARGET

}  // namespace
}  // namespace depth_one_lane

const DepthKernels& depth_kernels_plain() {
  static const DepthKernels kernels{depth_one_lane::smooth_row, depth_one_lane::find_holes, depth_one_lane::add_row,
                                    depth_one_lane::divide};
  return kernels;
}

const DepthKernels& depth_kernels() {
  return simd_level() == SimdLevel::avx2 ? depth_kernels_avx2() : depth_kernels_plain();
}

}  // namespace rastro
