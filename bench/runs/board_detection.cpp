// SPDX-License-Identifier: Apache-2.0
// Time and share of boards found in generated images with moderate blur and noise, 640x480 and 4k: rastro_bench_boards.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <opencv2/imgproc.hpp>

#include "rastro/calibration/board_detector.h"
#include "rastro/calibration/board_rendering_testing.h"
#include "rastro/calibration/boards_testing.h"

namespace {

using namespace rastro;

struct Case {
  const char* board;
  int scale;  ///< Of 640 pixels; 6 is cut to 16:9.
  int images;
};

/// The lens and image that are `scale` times as large.
Lens scaled(Lens lens, int scale, int cut_rows) {
  Eigen::VectorXd& p = lens.parameters;
  p.head<2>() *= scale;
  p[2] = (p[2] + 0.5) * scale - 0.5;
  p[3] = (p[3] + 0.5) * scale - 0.5 - cut_rows;
  return lens;
}

bool inside(const BoardProblem& problem, const Lens& lens, const SE3& pose, int width, int height) {
  for (int k = 0; k < static_cast<int>(problem.board.size()); ++k) {
    const auto seen = lens.project(pose * board_point(problem, k));
    const double margin = 0.03 * width;
    if (!seen || seen->pixel.x() < margin || seen->pixel.y() < margin || seen->pixel.x() > width - margin ||
        seen->pixel.y() > height - margin)
      return false;
  }
  return true;
}

void blur(GrayImage& image, double sigma) {
  cv::Mat mat(image.height(), image.width(), CV_8UC1, image.row(0), static_cast<std::size_t>(image.view().stride));
  cv::GaussianBlur(mat, mat, {}, sigma);
}

void run(const Case& run) {
  const Board board = parse_board(run.board);
  const GeneratedBoards made = generate_boards({.seed = 11, .frames = 4 * run.images, .noise_px = 0.0, .board = board});
  const int cut = run.scale == 6 ? 360 : 0, width = 640 * run.scale, height = 480 * run.scale - 2 * cut;
  const Lens lens = scaled(made.truth.lenses[0], run.scale, cut);
  const BoardRenderer renderer(board, lens, width, height);
  Random random(5);
  std::vector<double> times;
  int found = 0;
  for (const SE3& pose : made.truth.left_from_board) {
    if (static_cast<int>(times.size()) == run.images || !inside(made.truth, lens, pose, width, height)) continue;
    GrayImage image = renderer.render(pose, 4.0, random);
    blur(image, 0.8);
    const auto begin = std::chrono::steady_clock::now();
    found += detect_board(image.view(), board) ? 1 : 0;
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  fmt::print("{:<32} {}x{}: found in {} of {}, {:.1f} ms in the median, {:.1f} ms at 95 %\n", run.board, width, height,
             found, times.size(), times[times.size() / 2], times[times.size() * 95 / 100]);
}

}  // namespace

int main() {
  for (const Case& each : {Case{"chessboard:9x6:0.025", 1, 100}, Case{"charuco:8x6:0.03:0.02", 1, 50},
                           Case{"apriltag:5x4:0.036:0.0108", 1, 50}, Case{"chessboard:9x6:0.025", 6, 10},
                           Case{"charuco:8x6:0.03:0.02", 6, 5}, Case{"apriltag:5x4:0.036:0.0108", 6, 5}})
    run(each);
}
