// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <limits>

#include "rastro/base/simd.h"
#include "rastro/slam/lsd/depth/epipolar_kernels.h"
#include "rastro/slam/lsd/depth/epipolar_search.h"

#if RASTRO_HAS_AVX2_CODE
#include "rastro/slam/lsd/eight_lanes.h"
#endif

namespace rastro {

#if RASTRO_HAS_AVX2_CODE
namespace epipolar_eight_lanes {
namespace {

namespace lanes = eight_lanes;
#define RASTRO_LANES RASTRO_EIGHT_LANES
#define RASTRO_LANES_LAMBDA RASTRO_TARGET_AVX2 __attribute__((always_inline))
#define RASTRO_LANES_TARGET RASTRO_TARGET_AVX2
#include "rastro/slam/lsd/depth/epipolar_lanes.inc"
#undef RASTRO_LANES
#undef RASTRO_LANES_LAMBDA
#undef RASTRO_LANES_TARGET

}  // namespace
}  // namespace epipolar_eight_lanes

const EpipolarKernels& epipolar_kernels_avx2() {
  static const EpipolarKernels kernels{epipolar_eight_lanes::search_all};
  return kernels;
}
#else
const EpipolarKernels& epipolar_kernels_avx2() { return epipolar_kernels_plain(); }
#endif

}  // namespace rastro
