// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/calibration/depth_calibration.h"
#include "rastro/calibration/trust.h"
#include "rastro/camera/calibration_file.h"

namespace rastro {

/// A calibration with its judgment, as it is reported.
struct CalibrationReport {
  CalibrationInput input;
  CameraCalibration calibration;
  std::vector<CalibrationTrust> trust;  ///< Per camera.
  int images = 0;                       ///< Searched for the board.
  int found = 0;                        ///< Of these, with the board; more than the views where not all are kept.
  std::optional<DepthCalibration> depth = {};
  double readout_s = 0.0;  ///< Camera::readout_s, which images of a board that is held still do not tell.
};

/// The verdict in words.
const char* trust_word(Trust trust);

/// The cameras as calibration files have them: "left" and "right" of a pair, else "camera".
std::vector<CalibratedCameraEntry> calibrated_cameras(const CalibrationReport& report);

/// In words, for people: parameters with sigmas, residuals, what was left out, what is missing, the verdict.
std::string calibration_summary(const CalibrationReport& report);
/// The same and more for programs: calibration.json.
std::string calibration_json(const CalibrationReport& report);

/// The corners that were used of a camera, as mrcal reads them (corners.vnl): "filename x y level", every corner of the
/// board in its order, "- - -" for those that were left out.
std::string calibration_corners(const CalibrationReport& report, std::size_t camera);

/// Pictures as PNG files; Error where one cannot be written.
/// Every corner of a camera, with its residual 50 times as long as it is.
void write_residual_image(const CalibrationReport& report, std::size_t camera, const std::string& path);
/// The uncertainty of projection over the image, with its scale.
void write_uncertainty_image(const CalibrationReport& report, std::size_t camera, const std::string& path);

}  // namespace rastro
