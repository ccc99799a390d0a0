// SPDX-License-Identifier: Apache-2.0
// Time and share of good views (GoodView) in which a calibration board is found, 640x480 and 3840x2160:
// rastro_boards_bench. `found` is the share, with half of the corners or more; `ms_95` and `ms_most` are of single
// views.
#include <benchmark/benchmark.h>

#include <ctime>

#include "rastro/calibration/board_detector.h"
#include "rastro/calibration/board_views_testing.h"

namespace {

using namespace rastro;

/// Processor time, which other programs do not lengthen.
double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void find_boards(benchmark::State& state, const char* text, int scale, int views) {
  const Board board = parse_board(text);
  GoodViews good(board, 101, scale);
  std::vector<double> times;
  int found = 0;
  for (auto _ : state) {
    const GoodView view = good.next();
    const double begin = cpu_ms();
    const auto corners = detect_board(view.image.view(), board);
    times.push_back(cpu_ms() - begin);
    state.SetIterationTime(1e-3 * times.back());
    found += corners && 2 * corners->corners.size() >= view.corners.size() ? 1 : 0;
  }
  std::sort(times.begin(), times.end());
  state.counters["found"] = found / static_cast<double>(views);
  state.counters["ms_50"] = times[times.size() / 2];
  state.counters["ms_95"] = times[times.size() * 95 / 100];
  state.counters["ms_most"] = times.back();
}

#define RASTRO_BENCH_BOARD(name, text, scale, views)       \
  BENCHMARK_CAPTURE(find_boards, name, text, scale, views) \
      ->Iterations(views)                                  \
      ->UseManualTime()                                    \
      ->Unit(benchmark::kMillisecond)

RASTRO_BENCH_BOARD(chessboard, "chessboard:9x6:0.025", 1, 300);
RASTRO_BENCH_BOARD(charuco, "charuco:8x6:0.03:0.02", 1, 300);
RASTRO_BENCH_BOARD(apriltag, "apriltag:5x4:0.036:0.0108", 1, 300);
RASTRO_BENCH_BOARD(chessboard_4k, "chessboard:9x6:0.025", 6, 30);
RASTRO_BENCH_BOARD(charuco_4k, "charuco:8x6:0.03:0.02", 6, 30);
RASTRO_BENCH_BOARD(apriltag_4k, "apriltag:5x4:0.036:0.0108", 6, 30);

}  // namespace

BENCHMARK_MAIN();
