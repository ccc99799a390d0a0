// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"

namespace rastro {
namespace {

const char* camera_name(const CalibrationReport& report, std::size_t camera) {
  if (!report.input.stereo) return "camera";
  return camera == 0 ? "left" : "right";
}

/// Standard deviations of the relative pose of a pair: rotation (radians) and translation (meters).
Eigen::VectorXd pair_sigmas(const CameraCalibration& calibration) {
  return calibration.covariance.diagonal()
      .segment<6>(calibration.solution.parameters.right_from_left)
      .cwiseMax(0.0)
      .cwiseSqrt();
}

std::string parameter_lines(const CalibrationReport& report, std::size_t camera) {
  const Lens& lens = report.calibration.solution.problem.lenses[camera];
  const Eigen::VectorXd sigmas = report.calibration.lens_sigmas(camera);
  const auto& names = lens_parameter_names(lens.model);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    text += i < 4 ? fmt::format("  {:<3} {:10.3f} +- {:.3f} px\n", names[i], lens.parameters[at], sigmas[at])
                  : fmt::format("  {:<3} {:10.5f} +- {:.5f}\n", names[i], lens.parameters[at], sigmas[at]);
  }
  return text;
}

std::string pair_lines(const CalibrationReport& report) {
  if (!report.input.stereo) return "";
  const SE3& pose = report.calibration.solution.problem.right_from_left;
  const Eigen::VectorXd sigmas = pair_sigmas(report.calibration);
  const Eigen::Vector3d center = pose.inverse().translation();
  return fmt::format("  baseline {:.5f} +- {:.5f} m, rotation {:.3f} +- {:.3f} degrees\n", center.norm(),
                     sigmas.tail<3>().maxCoeff(), pose.rotation().log().norm() * 57.29578,
                     sigmas.head<3>().maxCoeff() * 57.29578);
}

std::string left_out_lines(const CalibrationReport& report) {
  std::string text;
  for (const LeftOut& frame : report.calibration.frames_left_out)
    text += fmt::format("left out: {}{}, {:.2f} px off\n", report.input.frames[static_cast<std::size_t>(frame.frame)],
                        frame.camera == 1 ? " (right)" : "", frame.rms_px);
  if (report.calibration.corners_left_out > 0)
    text += fmt::format("left out: {} single corners\n", report.calibration.corners_left_out);
  return text;
}

std::string trust_lines(const CalibrationTrust& trust) {
  std::string text = fmt::format(
      "  projection uncertain by {:.3f} px in the median, {:.3f} px at worst, {:.3f} px at the distance of the "
      "boards\n",
      trust.uncertainty_median_px, trust.uncertainty_largest_px, trust.uncertainty_near_px);
  if (trust.halves.done)
    text += fmt::format("  two halves of the images differ by {:.3f} px, {:.3f} px expected\n",
                        trust.halves.difference_px, trust.halves.expected_px);
  text += fmt::format("  corners in {:.0f} % of the image, boards at {:.2f} to {:.2f} m\n",
                      100.0 * trust.coverage.image_share, trust.coverage.nearest_m, trust.coverage.farthest_m);
  text += fmt::format("verdict: {}\n", trust_word(trust.trust));
  for (const std::string& line : trust.doubts) text += fmt::format("  - {}\n", line);
  return text;
}

nlohmann::ordered_json lens_json(const CalibrationReport& report, std::size_t camera) {
  nlohmann::ordered_json json;
  const Lens& lens = report.calibration.solution.problem.lenses[camera];
  const Eigen::VectorXd sigmas = report.calibration.lens_sigmas(camera);
  const auto& names = lens_parameter_names(lens.model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    json[std::string(names[i])] = {{"value", lens.parameters[at]}, {"sigma", sigmas[at]}};
  }
  return json;
}

nlohmann::ordered_json trust_json(const CalibrationTrust& trust) {
  nlohmann::ordered_json json;
  json["verdict"] = trust_word(trust.trust);
  json["doubts"] = trust.doubts;
  json["missing"] = trust.coverage.missing;
  json["image_share"] = trust.coverage.image_share;
  json["uncertainty_median_px"] = trust.uncertainty_median_px;
  json["uncertainty_largest_px"] = trust.uncertainty_largest_px;
  json["uncertainty_at_boards_px"] = trust.uncertainty_near_px;
  if (trust.halves.done) {
    json["halves_difference_px"] = trust.halves.difference_px;
    json["halves_expected_px"] = trust.halves.expected_px;
    json["halves_chi_square_per_parameter"] = trust.halves.chi_square;
  }
  json["uncertainty_map"] = {{"columns", trust.uncertainty.columns}, {"rows", trust.uncertainty.rows}};
  auto& values = json["uncertainty_map"]["px"] = nlohmann::ordered_json::array();
  for (const double value : trust.uncertainty.values)
    values.push_back(std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json());
  return json;
}

nlohmann::ordered_json frames_json(const CalibrationReport& report) {
  auto frames = nlohmann::ordered_json::array();
  const BoardSolution& solution = report.calibration.solution;
  for (std::size_t v = 0; v < solution.problem.views.size(); ++v) {
    const BoardView& view = solution.problem.views[v];
    double squared = 0.0;
    for (const Eigen::Vector2d& residual : solution.residuals[v]) squared += residual.squaredNorm();
    frames.push_back({{"name", report.input.frames[static_cast<std::size_t>(view.frame)]},
                      {"camera", camera_name(report, static_cast<std::size_t>(view.camera))},
                      {"corners", view.corners.size()},
                      {"rms_px", std::sqrt(squared / static_cast<double>(view.corners.size()))}});
  }
  return frames;
}

nlohmann::ordered_json models_json(const CameraCalibration& calibration) {
  auto models = nlohmann::ordered_json::array();
  for (const ModelFit& fit : calibration.models)
    models.push_back({{"model", std::string(lens_model_name(fit.model))},
                      {"rms_px", fit.rms_px},
                      {"holdout_px", fit.holdout_px},
                      {"bic", fit.bic}});
  return models;
}

nlohmann::ordered_json depth_json(const DepthCalibration& depth) {
  const Eigen::Vector3d rotation = depth.color_from_depth.rotation().log();
  const Eigen::Vector3d translation = depth.color_from_depth.translation();
  return {{"views", depth.views},
          {"scale", depth.scale},
          {"scale_sigma", depth.scale_sigma},
          {"offset_m", depth.offset_m},
          {"offset_sigma_m", depth.offset_sigma_m},
          {"sigma_m", depth.sigma_m},
          {"sigma_per_m2", depth.sigma_per_m2},
          {"color_from_depth",
           {{"rotation_rad", std::vector<double>(rotation.data(), rotation.data() + 3)},
            {"translation_m", std::vector<double>(translation.data(), translation.data() + 3)},
            {"rotation_sigma_rad", depth.rotation_sigma_rad},
            {"translation_sigma_m", depth.translation_sigma_m}}},
          {"doubts", depth.doubts}};
}

nlohmann::ordered_json shape_json(const ShapeFinding& shape) {
  return {{"bowed", shape.bowed},
          {"bow_x_m", shape.bow_x_m},
          {"bow_y_m", shape.bow_y_m},
          {"bow_sigma_m", shape.bow_sigma_m},
          {"stretched", shape.stretched},
          {"stretch_y", shape.stretch_y},
          {"stretch_sigma", shape.stretch_sigma}};
}

}  // namespace

const char* trust_word(Trust trust) {
  return trust == Trust::good ? "good" : trust == Trust::usable ? "usable, with doubts" : "do not use it";
}

std::vector<CalibratedCameraEntry> calibrated_cameras(const CalibrationReport& report) {
  std::vector<CalibratedCameraEntry> entries;
  const BoardProblem& problem = report.calibration.solution.problem;
  for (std::size_t camera = 0; camera < problem.lenses.size(); ++camera) {
    CalibratedCameraEntry entry;
    entry.name = camera_name(report, camera);
    entry.camera = camera_of(problem.lenses[camera], report.input.width, report.input.height);
    entry.camera.readout_s = report.readout_s;
    entry.calibration_error = report.calibration.lens_sigmas(camera)[0] / entry.camera.fx;
    if (camera == 1) entry.camera_from_previous = problem.right_from_left;
    entries.push_back(entry);
  }
  return entries;
}

std::string calibration_summary(const CalibrationReport& report) {
  const BoardSolution& solution = report.calibration.solution;
  std::string text = fmt::format(
      "{} views of the board used; found in {} of {} images; {}, {:.3f} px RMS{}\n", solution.problem.views.size(),
      report.found, report.images, lens_model_name(solution.problem.lenses.front().model), solution.rms_px(),
      report.calibration.holdout_px > 0.0 ? fmt::format(", {:.3f} px in images held out", report.calibration.holdout_px)
                                          : "");
  text += left_out_lines(report);
  for (std::size_t camera = 0; camera < report.trust.size(); ++camera) {
    text += fmt::format("{} ({}x{})\n", camera_name(report, camera), report.input.width, report.input.height);
    text += parameter_lines(report, camera);
    if (camera == 1) text += pair_lines(report);
    text += trust_lines(report.trust[camera]);
  }
  if (report.depth) text += depth_summary(*report.depth);
  return text;
}

std::string calibration_json(const CalibrationReport& report) {
  nlohmann::ordered_json json;
  const CameraCalibration& calibration = report.calibration;
  json["images"] = report.images;
  json["views"] = calibration.solution.problem.views.size();
  json["width"] = report.input.width;
  json["height"] = report.input.height;
  json["model"] = std::string(lens_model_name(calibration.solution.problem.lenses.front().model));
  json["rms_px"] = calibration.solution.rms_px();
  json["noise_px"] = calibration.solution.noise_px();
  json["holdout_px"] = calibration.holdout_px;
  for (std::size_t camera = 0; camera < report.trust.size(); ++camera) {
    json["cameras"][camera_name(report, camera)] = {{"parameters", lens_json(report, camera)},
                                                    {"trust", trust_json(report.trust[camera])}};
  }
  if (report.input.stereo) {
    const SE3& pose = calibration.solution.problem.right_from_left;
    const Eigen::Vector3d rotation = pose.rotation().log(), translation = pose.translation();
    const Eigen::VectorXd sigmas = pair_sigmas(calibration);
    json["right_from_left"] = {{"rotation_rad", std::vector<double>(rotation.data(), rotation.data() + 3)},
                               {"translation_m", std::vector<double>(translation.data(), translation.data() + 3)},
                               {"sigmas", std::vector<double>(sigmas.data(), sigmas.data() + 6)}};
  }
  if (report.depth) json["depth"] = depth_json(*report.depth);
  json["models"] = models_json(calibration);
  json["board"] = shape_json(calibration.shape);
  json["frames"] = frames_json(report);
  auto& left_out = json["frames_left_out"] = nlohmann::ordered_json::array();
  for (const LeftOut& frame : calibration.frames_left_out)
    left_out.push_back({{"name", report.input.frames[static_cast<std::size_t>(frame.frame)]},
                        {"camera", camera_name(report, static_cast<std::size_t>(frame.camera))},
                        {"rms_px", frame.rms_px}});
  json["corners_left_out"] = calibration.corners_left_out;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string calibration_corners(const CalibrationReport& report, std::size_t camera) {
  std::string text = "# filename x y level\n";
  for (const BoardView& view : report.calibration.solution.problem.views) {
    if (static_cast<std::size_t>(view.camera) != camera) continue;
    const std::string& name = report.input.frames[static_cast<std::size_t>(view.frame)];
    std::vector<std::string> lines(report.input.board.size(), fmt::format("{} - - -\n", name));
    for (std::size_t i = 0; i < view.corners.size(); ++i)
      lines[static_cast<std::size_t>(view.corners[i])] =
          fmt::format("{} {:.6f} {:.6f} 0\n", name, view.pixels[i].x(), view.pixels[i].y());
    for (const std::string& line : lines) text += line;
  }
  return text;
}

}  // namespace rastro
