// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rastro/calibration/projection_uncertainty.h"

namespace rastro {

/// Where and how the boards were seen by one camera.
struct BoardCoverage {
  static constexpr int cells_a_side = 6, ninths_a_side = 3;
  static constexpr double wanted_tilt_deg = 15.0;           ///< To either of two opposite sides.
  std::array<bool, cells_a_side * cells_a_side> seen{};     ///< Of the cells of the image, row by row: has a corner.
  std::array<bool, ninths_a_side * ninths_a_side> empty{};  ///< Of the ninths: most of their cells have none.
  std::array<bool, 4> empty_edges{};                        ///< Left, right, upper, lower: the outermost cells.
  bool lacks_tilt_sideways = true, lacks_tilt_up_down = true;
  double image_share = 0.0;                           ///< Of 6x6 cells of the image with a corner.
  double largest_tilt_deg[4] = {0.0, 0.0, 0.0, 0.0};  ///< Left, right, up, down: of the board's normal.
  double nearest_m = 0.0, farthest_m = 0.0;
  std::vector<std::string> missing;  ///< "lower left", "the left edge", "tilted boards"; empty where nothing is.
};
BoardCoverage board_coverage(const BoardSolution& solution, std::size_t camera, int width, int height);

/// Two halves of the frames, calibrated on their own.
struct CrossValidation {
  bool done = false;           ///< False with too few frames.
  double difference_px = 0.0;  ///< RMS over the image between both, infinitely far.
  double expected_px = 0.0;    ///< The same from the uncertainty of both.
  double chi_square = 0.0;     ///< Of the difference of all parameters of the lens, per parameter; 1 is expected.
  bool agree = true;
};
CrossValidation cross_validate(const CameraCalibration& calibration, std::size_t camera, int width, int height);

enum class Trust { good, usable, bad };

/// Judgment of the calibration of one camera.
struct CalibrationTrust {
  ImageMap uncertainty;  ///< Infinitely far, pixels.
  double uncertainty_median_px = 0.0;
  double uncertainty_largest_px = 0.0;
  double uncertainty_near_px = 0.0;  ///< Median at the mean distance of the boards.
  BoardCoverage coverage;
  CrossValidation halves;
  Trust trust = Trust::good;
  std::vector<std::string> doubts;  ///< What speaks against it, worst first; one plain line each.
};

/// `camera`: 0, or 1 for the right one.
CalibrationTrust judge_calibration(const CameraCalibration& calibration, std::size_t camera, int width, int height);
/// Adds a doubt where the baseline of a pair is not the known one: then the side of the squares is wrong by that share,
/// which images alone cannot tell.
void judge_baseline(const CameraCalibration& calibration, double known_m, CalibrationTrust& trust);

}  // namespace rastro
