// SPDX-License-Identifier: Apache-2.0
// One step of EKF-SLAM over the number of landmarks: rastro_ekf_bench. An update should scale with its square, the rest
// linearly.
#include <benchmark/benchmark.h>

#include <vector>

#include "rastro/base/random.h"
#include "rastro/slam/ekf/filter.h"

namespace {

using namespace rastro;

const Eigen::Matrix3d motion_noise = Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
const Eigen::Matrix2d sensor_noise = 0.01 * Eigen::Matrix2d::Identity();
const std::vector<std::int64_t> numbers = {50, 100, 200, 400, 800, 1600};
const SE2 step(SO2::from_angle(0.01), {0.1, 0.0});

EkfFilter filter_with(benchmark::State& state) {
  Random random(1);
  EkfFilter filter;
  for (std::int64_t i = 0; i < state.range(0); ++i) {
    filter.predict(step, motion_noise);
    filter.add({random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0)}, sensor_noise);
  }
  return filter;
}

void update(benchmark::State& state) {
  EkfFilter filter = filter_with(state);
  std::size_t landmark = 0;
  for (auto _ : state) {
    landmark = (landmark + 7) % filter.landmarks();
    filter.update(landmark, filter.expected(landmark).in_body, sensor_noise);
  }
  state.SetComplexityN(state.range(0));
}
BENCHMARK(update)->ArgsProduct({numbers})->Unit(benchmark::kMicrosecond)->Complexity(benchmark::oNSquared);

void predict(benchmark::State& state) {
  EkfFilter filter = filter_with(state);
  for (auto _ : state) filter.predict(step, motion_noise);
  state.SetComplexityN(state.range(0));
}
BENCHMARK(predict)->ArgsProduct({numbers})->Unit(benchmark::kMicrosecond)->Complexity(benchmark::oN);

void expectation_of_all(benchmark::State& state) {
  const EkfFilter filter = filter_with(state);
  for (auto _ : state) {
    for (std::size_t i = 0; i < filter.landmarks(); ++i) benchmark::DoNotOptimize(filter.expected(i));
  }
  state.SetComplexityN(state.range(0));
}
BENCHMARK(expectation_of_all)->ArgsProduct({numbers})->Unit(benchmark::kMicrosecond)->Complexity(benchmark::oN);

}  // namespace

BENCHMARK_MAIN();
