// SPDX-License-Identifier: Apache-2.0
// Direct image alignment of a rendered 640x480 view with 30,000 points: rastro_direct_bench.
#include <benchmark/benchmark.h>

#include "rastro/base/simd_testing.h"
#include "rastro/slam/lsd/depth/depth_kernels.h"
#include "rastro/slam/lsd/depth/depth_map.h"
#include "rastro/slam/lsd/tracking/alignment_testing.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"
#include "rastro/slam/lsd/tracking/similarity_alignment.h"

namespace {

using namespace rastro;

constexpr int levels = 5, points = 30'000;
/// Of the frame before, as tracking has it: about 5 px of motion remain.
const SE3 image_from_reference = SE3::exp((Vector6d() << 0.03, -0.01, 0.02, 0.004, -0.006, 0.003).finished());

struct Views {
  rastro::testing::AlignmentRoom room{640, 480};
  RenderedFrame keyframe = room.render(SE3());
  GrayImage image = room.render(image_from_reference.inverse()).gray;
  InverseDepthMap depth = rastro::testing::semi_dense_depth(keyframe, 5.0, 0.03, 1);
  Pyramid keyframe_pyramid = alignment_pyramid(keyframe.gray, levels), image_pyramid = alignment_pyramid(image, levels);
  AlignmentReference reference;

  Views() { reference.build(keyframe_pyramid, depth, room.camera(), {levels, 3.0, points}); }
};
const Views& views() {
  static const Views views;
  return views;
}

void pyramid(benchmark::State& state) {
  Pyramid pyramid;
  for (auto _ : state) pyramid.build(views().image, levels, alignment_padding);
}
BENCHMARK(pyramid)->Unit(benchmark::kMillisecond);

void reference(benchmark::State& state) {
  AlignmentReference reference;
  for (auto _ : state)
    reference.build(views().keyframe_pyramid, views().depth, views().room.camera(), {levels, 3.0, points});
}
BENCHMARK(reference)->Unit(benchmark::kMillisecond);

/// One evaluation of the residuals and their sums on level 0, as every iteration makes it.
void linearize(benchmark::State& state, const AlignmentKernels& kernels) {
  const AlignmentPoints& all = views().reference.level(0);
  const AlignmentView view =
      alignment_view(views().image_pyramid.level(0), all.camera, image_from_reference, 1.0, 128.0, {});
  AlignmentColumns columns;
  AlignmentSums sums;
  for (auto _ : state) {
    for (int begin = 0; begin < all.count; begin += alignment_chunk) {
      kernels.linearize(all, begin, std::min(begin + alignment_chunk, all.count), view, columns);
      kernels.accumulate(columns, sums);
    }
    benchmark::DoNotOptimize(sums);
  }
  state.SetItemsProcessed(state.iterations() * all.count);
}
BENCHMARK_CAPTURE(linearize, plain, alignment_kernels_plain())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(linearize, avx2, alignment_kernels_avx2())->Unit(benchmark::kMicrosecond);

void align(benchmark::State& state) {
  ImageAlignmentOptions options;
  options.finest_level = static_cast<int>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(align_image(views().reference, views().image_pyramid, SE3(), options));
}
BENCHMARK(align)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void align_plain(benchmark::State& state) {
  rastro::testing::with_plain_code([&] {
    for (auto _ : state) benchmark::DoNotOptimize(align_image(views().reference, views().image_pyramid, SE3()));
  });
}
BENCHMARK(align_plain)->Unit(benchmark::kMillisecond);

void similarity(benchmark::State& state) {
  const SimilarityTarget target{views().keyframe_pyramid, views().reference.depth()};
  const Sim3 guess(SE3::exp((Vector6d() << 0.02, 0.0, 0.01, 0.004, -0.006, 0.003).finished()));
  for (auto _ : state) benchmark::DoNotOptimize(align_similarity(views().reference, target, guess));
}
BENCHMARK(similarity)->Unit(benchmark::kMillisecond);

void smooth(benchmark::State& state, const DepthKernels& kernels) {
  std::vector<float> row(640);
  for (auto _ : state)
    for (int y = 4; y < 476; ++y) {
      kernels.smooth_row(views().depth, y, {.border = 4}, row.data());
      benchmark::DoNotOptimize(row.data());
    }
}
BENCHMARK_CAPTURE(smooth, plain, depth_kernels_plain())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(smooth, avx2, depth_kernels_avx2())->Unit(benchmark::kMillisecond);

/// All that a frame tells about the depths of its keyframe.
void observe(benchmark::State& state) {
  DepthMap map(views().keyframe.gray.view(), views().room.camera(), {});
  map.start_from(views().depth);
  for (auto _ : state) benchmark::DoNotOptimize(map.observe(views().image.view(), image_from_reference, 1.0, 0.0));
}
BENCHMARK(observe)->Unit(benchmark::kMillisecond);

void observe_plain(benchmark::State& state) {
  rastro::testing::with_plain_code([&] { observe(state); });
}
BENCHMARK(observe_plain)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
