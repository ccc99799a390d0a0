// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/simd.h"
#include "rastro/slam/lsd/tracking/alignment_kernels.h"

#if RASTRO_HAS_AVX2_CODE
#include "rastro/slam/lsd/avx2_lanes.h"
#endif

namespace rastro {

#if RASTRO_HAS_AVX2_CODE
namespace {

// Every expression below has a twin in alignment_kernels.cpp that rounds in the same order.

using lanes::add, lanes::all, lanes::between, lanes::mul, lanes::sub;
/// a x + b y + c z, the third product added last.
RASTRO_TARGET_AVX2 inline __m256 dot(float a, __m256 x, float b, __m256 y, float c, __m256 z) {
  return add(add(mul(all(a), x), mul(all(b), y)), mul(all(c), z));
}

struct EightPoints {
  __m256 x, y, inverse_depth, variance, intensity, gradient_x, gradient_y;
};

RASTRO_TARGET_AVX2 inline EightPoints load_points(const AlignmentPoints& points, int at) {
  const auto k = static_cast<std::size_t>(at);
  return {_mm256_loadu_ps(&points.x[k]),
          _mm256_loadu_ps(&points.y[k]),
          _mm256_loadu_ps(&points.inverse_depth[k]),
          _mm256_loadu_ps(&points.variance[k]),
          _mm256_loadu_ps(&points.intensity[k]),
          _mm256_loadu_ps(&points.gradient_x[k]),
          _mm256_loadu_ps(&points.gradient_y[k])};
}

struct EightProjections {
  __m256 u, v, inverse_depth, pixel_x, pixel_y, inside;
};

RASTRO_TARGET_AVX2 inline __m256 moved(const AlignmentView& view, int axis, const EightPoints& p) {
  const float* r = view.rotation + 3 * axis;
  return add(add(add(mul(all(r[0]), p.x), mul(all(r[1]), p.y)), all(r[2])),
             mul(all(view.translation[axis]), p.inverse_depth));
}

RASTRO_TARGET_AVX2 inline EightProjections project(const AlignmentView& view, const EightPoints& points) {
  const __m256 z = moved(view, 2, points);
  EightProjections p;
  p.inverse_depth = _mm256_div_ps(all(1.0F), z);
  p.u = mul(moved(view, 0, points), p.inverse_depth);
  p.v = mul(moved(view, 1, points), p.inverse_depth);
  p.pixel_x = add(mul(all(view.fx), p.u), all(view.cx));
  p.pixel_y = add(mul(all(view.fy), p.v), all(view.cy));
  const __m256 zero = _mm256_setzero_ps();
  const __m256 in_x =
      _mm256_and_ps(_mm256_cmp_ps(p.pixel_x, zero, _CMP_GE_OQ), _mm256_cmp_ps(p.pixel_x, all(view.last_x), _CMP_LT_OQ));
  const __m256 in_y =
      _mm256_and_ps(_mm256_cmp_ps(p.pixel_y, zero, _CMP_GE_OQ), _mm256_cmp_ps(p.pixel_y, all(view.last_y), _CMP_LT_OQ));
  p.inside = _mm256_and_ps(_mm256_cmp_ps(z, zero, _CMP_GT_OQ), _mm256_and_ps(in_x, in_y));
  return p;
}

RASTRO_TARGET_AVX2 inline __m256 sample(const AlignmentView& view, const EightProjections& p) {
  const __m256 x = _mm256_and_ps(p.pixel_x, p.inside), y = _mm256_and_ps(p.pixel_y, p.inside);
  const __m256i column = _mm256_cvttps_epi32(x), row = _mm256_cvttps_epi32(y);
  const __m256 fraction_x = sub(x, _mm256_cvtepi32_ps(column)), fraction_y = sub(y, _mm256_cvtepi32_ps(row));
  const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(row, _mm256_set1_epi32(view.stride)), column);
  const __m256i above = _mm256_i32gather_epi32(reinterpret_cast<const int*>(view.pixels), at, 1);
  const __m256i below = _mm256_i32gather_epi32(reinterpret_cast<const int*>(view.pixels + view.stride), at, 1);
  const __m256 top = between(above, fraction_x), bottom = between(below, fraction_x);
  return add(top, mul(fraction_y, sub(bottom, top)));
}

RASTRO_TARGET_AVX2 inline void store(float* to, __m256 value, __m256 where) {
  _mm256_store_ps(to, _mm256_and_ps(value, where));
}

RASTRO_TARGET_AVX2 inline __m256 jacobian(const EightPoints& points, const AlignmentView& view,
                                          const EightProjections& p, __m256 used, AlignmentColumns& columns, int i) {
  const float *r = view.rotation, *t = view.translation, *turn = view.gradient_turn;
  const __m256 gx = points.gradient_x, gy = points.gradient_y;
  const __m256 a0 = mul(add(mul(all(turn[0]), gx), mul(all(turn[1]), gy)), p.inverse_depth);
  const __m256 a1 = mul(add(mul(all(turn[2]), gx), mul(all(turn[3]), gy)), p.inverse_depth);
  const __m256 a2 = sub(_mm256_setzero_ps(), add(mul(a0, p.u), mul(a1, p.v)));
  const __m256 b0 = dot(r[0], a0, r[3], a1, r[6], a2);
  const __m256 b1 = dot(r[1], a0, r[4], a1, r[7], a2);
  const __m256 b2 = dot(r[2], a0, r[5], a1, r[8], a2);
  store(columns.column[0] + i, mul(points.inverse_depth, b0), used);
  store(columns.column[1] + i, mul(points.inverse_depth, b1), used);
  store(columns.column[2] + i, mul(points.inverse_depth, b2), used);
  store(columns.column[3] + i, sub(mul(points.y, b2), b1), used);
  store(columns.column[4] + i, sub(b0, mul(points.x, b2)), used);
  store(columns.column[5] + i, sub(mul(points.x, b1), mul(points.y, b0)), used);
  return dot(t[0], a0, t[1], a1, t[2], a2);
}

RASTRO_TARGET_AVX2 inline void weigh(__m256 residual, __m256 by_inverse_depth, const EightPoints& points,
                                     const AlignmentView& view, __m256 used, AlignmentColumns& columns, int i) {
  const __m256 from_depth = mul(mul(by_inverse_depth, by_inverse_depth), points.variance);
  const __m256 precision = _mm256_div_ps(all(1.0F), add(all(view.noise_variance), from_depth));
  const __m256 squared = mul(mul(residual, residual), precision);
  const __m256 error = _mm256_sqrt_ps(squared), width = all(view.huber_width);
  store(columns.column[8] + i, residual, used);
  store(columns.weight + i, mul(_mm256_min_ps(all(1.0F), _mm256_div_ps(width, error)), precision), used);
  const __m256 capped = _mm256_min_ps(error, width);
  const __m256 cost = _mm256_and_ps(mul(capped, sub(add(error, error), capped)), used);
  _mm256_store_ps(columns.cost_lanes, add(_mm256_load_ps(columns.cost_lanes), cost));
  const __m256 inlier = _mm256_and_ps(_mm256_cmp_ps(squared, all(9.0F), _CMP_LT_OQ), used);
  columns.inliers += __builtin_popcount(static_cast<unsigned>(_mm256_movemask_ps(inlier)));
}

RASTRO_TARGET_AVX2 inline void linearize_eight(const EightPoints& points, const AlignmentView& view,
                                               AlignmentColumns& columns, int i) {
  const EightProjections p = project(view, points);
  const __m256 intensity = sample(view, p);
  const __m256 clear = _mm256_and_ps(_mm256_cmp_ps(intensity, all(view.darkest), _CMP_GT_OQ),
                                     _mm256_cmp_ps(intensity, all(view.brightest), _CMP_LT_OQ));
  const __m256 used = _mm256_and_ps(p.inside, clear);
  columns.inside += __builtin_popcount(static_cast<unsigned>(_mm256_movemask_ps(p.inside)));
  columns.used += __builtin_popcount(static_cast<unsigned>(_mm256_movemask_ps(used)));
  const __m256 by_inverse_depth = jacobian(points, view, p, used, columns, i);
  store(columns.column[6] + i, sub(_mm256_setzero_ps(), points.intensity), used);
  store(columns.column[7] + i, all(-1.0F), used);
  const __m256 residual = sub(sub(intensity, mul(all(view.gain), points.intensity)), all(view.offset));
  weigh(residual, by_inverse_depth, points, view, used, columns, i);
}

RASTRO_TARGET_AVX2 void linearize_avx2(const AlignmentPoints& points, int begin, int end, const AlignmentView& view,
                                       AlignmentColumns& columns) {
  columns.points = (end - begin + 7) / 8 * 8;
  columns.inside = columns.used = columns.inliers = 0;
  _mm256_store_ps(columns.cost_lanes, _mm256_setzero_ps());
  for (int i = 0; i < columns.points; i += 8) linearize_eight(load_points(points, begin + i), view, columns, i);
}

RASTRO_TARGET_AVX2 inline double sum_of(__m256 value) {
  alignas(32) float lanes[8];
  _mm256_store_ps(lanes, value);
  double sum = 0.0;
  for (const float lane : lanes) sum += static_cast<double>(lane);
  return sum;
}

/// Products of column `Row` with itself and the later ones. The compiler unrolls the inner loops, so that the sums stay
/// in registers.
template <int Row>
RASTRO_TARGET_AVX2 inline void accumulate_row(const AlignmentColumns& columns, double* out) {
  constexpr int count = alignment_columns - Row;
  __m256 sums[count];
  for (__m256& sum : sums) sum = _mm256_setzero_ps();
  for (int i = 0; i < columns.points; i += 8) {
    const __m256 weighted = mul(_mm256_load_ps(columns.weight + i), _mm256_load_ps(columns.column[Row] + i));
#pragma GCC unroll 9
    for (int j = 0; j < count; ++j) sums[j] = add(sums[j], mul(weighted, _mm256_load_ps(columns.column[Row + j] + i)));
  }
  for (int j = 0; j < count; ++j) out[j] = sum_of(sums[j]);
}

RASTRO_TARGET_AVX2 void accumulate_avx2(const AlignmentColumns& columns, AlignmentSums& sums) {
  double* out = sums.products.data();
  accumulate_row<0>(columns, out);
  accumulate_row<1>(columns, out + 9);
  accumulate_row<2>(columns, out + 17);
  accumulate_row<3>(columns, out + 24);
  accumulate_row<4>(columns, out + 30);
  accumulate_row<5>(columns, out + 35);
  accumulate_row<6>(columns, out + 39);
  accumulate_row<7>(columns, out + 42);
  accumulate_row<8>(columns, out + 44);
  sums.cost = sum_of(_mm256_load_ps(columns.cost_lanes));
  sums.inside = columns.inside;
  sums.used = columns.used;
  sums.inliers = columns.inliers;
}

}  // namespace

const AlignmentKernels& alignment_kernels_avx2() {
  static const AlignmentKernels kernels{linearize_avx2, accumulate_avx2};
  return kernels;
}
#else
const AlignmentKernels& alignment_kernels_avx2() { return alignment_kernels_plain(); }
#endif

}  // namespace rastro
