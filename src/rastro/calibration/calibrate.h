// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/optimize/board_adjustment.h"

namespace rastro {

/// What is calibrated: corners found in images.
struct CalibrationInput {
  std::vector<Eigen::Vector2d> board;  ///< Points in the plane of the board, meters.
  std::vector<std::string> frames;     ///< Names, for messages.
  int width = 0, height = 0;           ///< Of every image, pixels.
  bool stereo = false;
  std::vector<BoardView> views;
};

struct CalibrationOptions {
  std::optional<LensModel> model;  ///< Not given: the simplest that is good enough.
  /// Compares all models, and the halves of the frames with each other; else only the first fit is made.
  bool compare_models = true;
  double outlier_sigmas = 5.0;  ///< A corner farther off than this is left out.
  double bad_frame = 3.0;       ///< A frame whose error is this many times the median of all is left out.
};

/// A frame or corner that was left out.
struct LeftOut {
  int frame = 0;
  int camera = 0;
  double rms_px = 0.0;  ///< Before it was left out.
};

/// One of the models that were compared.
struct ModelFit {
  LensModel model = LensModel::pinhole_4;
  double rms_px = 0.0;
  double holdout_px = 0.0;  ///< Of the frames of the other half; 0 where it was not needed, or too few.
  double bic = 0.0;         ///< Schwarz 1978, with the noise from the residuals; smaller is better.
};

/// Whether the board is what its drawing says, judged with the model that fits best.
struct ShapeFinding {
  bool bowed = false;
  double bow_x_m = 0.0, bow_y_m = 0.0;  ///< BoardShape.
  double bow_sigma_m = 0.0;             ///< Of the larger one.
  bool stretched = false;
  double stretch_y = 0.0, stretch_sigma = 0.0;
};

struct CameraCalibration {
  BoardSolution solution;  ///< With the views that were used; the shape of the board is free where it is not as drawn.
  Eigen::MatrixXd covariance;  ///< Of all its parameters, scaled by the noise.
  std::vector<LeftOut> frames_left_out;
  int corners_left_out = 0;
  std::vector<ModelFit> models;                 ///< Those compared.
  LensModel best_model = LensModel::pinhole_4;  ///< Of all; may be one that was not asked for.
  ShapeFinding shape;
  double holdout_px = 0.0;            ///< RMS of frames that were not used, each half against the lens of the other.
  std::vector<BoardSolution> halves;  ///< Even and odd frames; empty where there are too few.
  std::vector<Eigen::MatrixXd> half_covariances;

  Eigen::VectorXd lens_sigmas(std::size_t camera) const;
};

/// Estimates lens, poses and the relative pose of a pair by bundle adjustment (Zhang 2000), robust to frames and
/// corners that are wrong; each standard deviation is from the residuals of this calibration. Throws Error where the
/// views do not determine a camera: fewer than 3 frames, all boards parallel, an image size of 0.
CameraCalibration calibrate_camera(const CalibrationInput& input, const CalibrationOptions& options = {});

/// The least squares solution for another model or with a free shape of the board, from the same views.
BoardSolution refit(const BoardSolution& solution, LensModel model, bool free_bow, bool free_stretch);

}  // namespace rastro
