// SPDX-License-Identifier: Apache-2.0
// ORB against OpenCV's with the same number of features, on a generated image full of corners: rastro_orb_bench.
#include <benchmark/benchmark.h>

#include <opencv2/features2d.hpp>

#include "rastro/feature/orb.h"
#include "rastro/image/image_testing.h"
#include "rastro/image/pyramid.h"

namespace {

using namespace rastro;

/// Noise, smoothed and stretched, with blobs and corners of several sizes.
GrayImage textured_image(int width, int height) {
  Pyramid pyramid;
  pyramid.build(rastro::testing::noise_image(2 * width, 2 * height, 1).view(), 3, 40);
  GrayImage made(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int value = 128 + 2 * (pyramid.level(1).row(y)[x] - 128) + 2 * (pyramid.level(2).row(y / 2)[x / 2] - 128);
      made.at(x, y) = static_cast<std::uint8_t>(value < 0 ? 0 : value > 255 ? 255 : value);
    }
  }
  return made;
}

void orb(benchmark::State& state) {
  const GrayImage image = textured_image(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  OrbOptions options;
  options.features = static_cast<int>(state.range(2));
  OrbExtractor extractor(options);
  std::size_t found = 0;
  for (auto _ : state) found = extractor.extract(image.view()).size();
  state.counters["features"] = static_cast<double>(found);
}

void orb_of_opencv(benchmark::State& state) {
  cv::setNumThreads(1);
  GrayImage image = textured_image(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const cv::Mat mat(image.height(), image.width(), CV_8U, image.row(0), static_cast<std::size_t>(image.stride()));
  const auto extractor = cv::ORB::create(static_cast<int>(state.range(2)), 1.2F, 8, 31, 0, 2, cv::ORB::FAST_SCORE);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  for (auto _ : state) extractor->detectAndCompute(mat, {}, keypoints, descriptors);
  state.counters["features"] = static_cast<double>(keypoints.size());
}

BENCHMARK(orb)->Args({640, 480, 1000})->Args({752, 480, 1000})->Args({1241, 376, 2000})->Unit(benchmark::kMillisecond);
BENCHMARK(orb_of_opencv)
    ->Args({640, 480, 1000})
    ->Args({752, 480, 1000})
    ->Args({1241, 376, 2000})
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
