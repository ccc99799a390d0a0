// SPDX-License-Identifier: Apache-2.0
// The tracker's inner steps on a 752x480 image of noise-free waves or on random descriptors: rastro_track_bench.
#include <benchmark/benchmark.h>

#include "rastro/feature/brief.h"
#include "rastro/feature/corner.h"
#include "rastro/feature/hamming.h"
#include "rastro/image/box_sum.h"
#include "rastro/image/image_testing.h"
#include "rastro/image/pyramid.h"
#include "rastro/multiview/homography.h"
#include "rastro/track/klt.h"
#include "rastro/track/voting.h"

namespace {

using namespace rastro;

constexpr int width = 752, height = 480;

Pyramid pyramid_of(double dx, double dy) {
  Pyramid pyramid;
  pyramid.build(rastro::testing::wave_image(width, height, dx, dy).view(), 4, klt_padding);
  return pyramid;
}

void klt(benchmark::State& state) {
  const Pyramid a = pyramid_of(0.0, 0.0), b = pyramid_of(4.3, -2.1);
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < 150; ++i) points.emplace_back(40.0F + 45.0F * (i % 15), 40.0F + 40.0F * (i / 15));
  std::vector<KltResult> results(points.size());
  for (auto _ : state) klt_follow(a, b, points, points, {}, nullptr, results);
  state.SetItemsProcessed(state.iterations() * 150);
}
BENCHMARK(klt)->Unit(benchmark::kMicrosecond);

void detection(benchmark::State& state) {
  const Pyramid image = pyramid_of(0.0, 0.0);
  GrayImage free(width, height);
  for (int y = 0; y < height; ++y) std::memset(free.row(y), 255, width);
  CornerDetector detector;
  for (auto _ : state) benchmark::DoNotOptimize(detector.detect(image.level(0), free.view(), 150, {}));
}
BENCHMARK(detection)->Unit(benchmark::kMicrosecond);

void brief(benchmark::State& state) {
  const Pyramid image = pyramid_of(0.0, 0.0);
  Image<std::uint16_t> sums;
  box_sums(image.level(0), 4, sums);
  const Brief describer(48, 1);
  for (auto _ : state) benchmark::DoNotOptimize(describer.describe(sums, 300.0F, 200.0F));
}
BENCHMARK(brief)->Unit(benchmark::kNanosecond);

Descriptor random_descriptor(Random& random) {
  Descriptor descriptor;
  for (auto& word : descriptor.words) word = random.next();
  return descriptor;
}

void hamming(benchmark::State& state) {
  Random random(1);
  std::vector<Descriptor> descriptors(4500);
  for (auto& descriptor : descriptors) descriptor = random_descriptor(random);
  std::vector<std::uint16_t> distances(descriptors.size());
  for (auto _ : state) hamming_distances(descriptors[7], descriptors, distances);
  state.SetItemsProcessed(state.iterations() * 4500);
}
BENCHMARK(hamming)->Unit(benchmark::kMicrosecond);

/// One corner against `range` lost tracks with observations in all 30 frames of the window.
void matching(benchmark::State& state) {
  Random random(1);
  TrackStore store(30);
  for (std::int64_t i = 0; i < state.range(0); ++i) {
    const std::size_t track = store.create();
    const Descriptor descriptor = random_descriptor(random);
    for (std::int64_t frame = 0; frame < 30; ++frame)
      store[track].observe(frame, {0.0F, 0.0F}, {0.0F, 0.0F}, descriptor);
    store.mark_lost(track);
  }
  Voting voting(store, 30, {});
  const Descriptor corner = random_descriptor(random);
  for (auto _ : state) benchmark::DoNotOptimize(voting.candidates_for(std::span(&corner, 1)));
}
BENCHMARK(matching)->Arg(150)->Arg(1000)->Unit(benchmark::kMicrosecond);

/// A homography of 100 pairs, a third of them wrong.
void validation(benchmark::State& state) {
  Random random(1);
  PointPairs pairs;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2f a(static_cast<float>(random.uniform(0, width)),
                            static_cast<float>(random.uniform(0, height)));
    const Eigen::Vector2f wrong(static_cast<float>(random.uniform(0, width)),
                                static_cast<float>(random.uniform(0, height)));
    pairs.add(a, i % 3 == 0 ? wrong : Eigen::Vector2f(1.01F * a.x() + 5.0F, 0.99F * a.y() - 3.0F));
  }
  for (auto _ : state) benchmark::DoNotOptimize(estimate_homography(pairs, {2.5, 0.99, 200, 1}));
}
BENCHMARK(validation)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
