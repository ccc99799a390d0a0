// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_kernels.h"

#include <algorithm>
#include <bit>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include "rastro/slam/lsd/eight_lanes.h"
#endif

namespace rastro {

#if RASTRO_HAS_AVX2_CODE
namespace depth_eight_lanes {
namespace {

namespace lanes = eight_lanes;
#define RASTRO_LANES RASTRO_EIGHT_LANES
#define RASTRO_LANES_TARGET RASTRO_TARGET_AVX2
#include "rastro/slam/lsd/depth/depth_lanes.inc"
#undef RASTRO_LANES
#undef RASTRO_LANES_TARGET

}  // namespace
}  // namespace depth_eight_lanes

const DepthKernels& depth_kernels_avx2() {
  static const DepthKernels kernels{depth_eight_lanes::smooth_row, depth_eight_lanes::find_holes,
                                    depth_eight_lanes::add_row, depth_eight_lanes::divide};
  return kernels;
}
#else
const DepthKernels& depth_kernels_avx2() { return depth_kernels_plain(); }
#endif

}  // namespace rastro
