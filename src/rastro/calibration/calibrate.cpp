// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/calibrate.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "rastro/base/error.h"
#include "rastro/calibration/board_start.h"

namespace rastro {
namespace {

constexpr int fewest_frames = 3;
constexpr int fewest_for_halves = 8;
constexpr double huber_px = 1.0;

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double rms_of_view(const std::vector<Eigen::Vector2d>& residuals) {
  double sum = 0.0;
  for (const Eigen::Vector2d& residual : residuals) sum += residual.squaredNorm();
  return std::sqrt(sum / std::max<double>(1.0, static_cast<double>(residuals.size())));
}

/// Views of a camera with their poses in it, after a bundle adjustment of this camera alone.
struct OneCamera {
  Lens lens;
  std::map<int, SE3> camera_from_board;  ///< By frame.
};

OneCamera fit_one_camera(const CalibrationInput& input, int camera, LensModel model) {
  std::vector<const BoardView*> views;
  for (const BoardView& view : input.views)
    if (view.camera == camera) views.push_back(&view);
  if (views.size() < fewest_frames)
    throw Error(
        "different views of the board: " + std::to_string(views.size()), camera == 0 ? "DATA" : "--right",
        "at least 3 are needed, better 20 or more: move it between the images; where it should be in more, check the "
        "number of inner corners of --board");
  const BoardStart start = start_boards(input.board, views, model, input.width, input.height);
  BoardProblem problem{input.board, {start.lens}, {}, std::vector<SE3>(input.frames.size()), {}, {}};
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!start.camera_from_board[i]) continue;
    problem.views.push_back(*views[i]);
    problem.views.back().camera = 0;
    problem.left_from_board[static_cast<std::size_t>(views[i]->frame)] = *start.camera_from_board[i];
  }
  if (problem.views.size() < fewest_frames)
    throw Error("no focal length explains the corners", "DATA", "check the number of inner corners of --board");
  BoardAdjustmentOptions options;
  options.huber_px = huber_px;
  const BoardSolution solution = adjust_boards(problem, options);
  OneCamera result{solution.problem.lenses.front(), {}};
  for (const BoardView& view : solution.problem.views)
    result.camera_from_board[view.frame] = solution.problem.left_from_board[static_cast<std::size_t>(view.frame)];
  return result;
}

/// The relative pose that is nearest to those of all other frames.
SE3 median_right_from_left(const OneCamera& left, const OneCamera& right) {
  std::vector<SE3> all;
  for (const auto& [frame, left_from_board] : left.camera_from_board)
    if (const auto found = right.camera_from_board.find(frame); found != right.camera_from_board.end())
      all.push_back(found->second * left_from_board.inverse());
  if (all.size() < fewest_frames)
    throw Error("the board was found in both images of " + std::to_string(all.size()) + " pairs", "--right",
                "at least 3 are needed, better 20 or more");
  std::size_t best = 0;
  double smallest = 1e300;
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<double> distances;
    for (const SE3& other : all) distances.push_back((all[i].inverse() * other).log().norm());
    const double distance = median_of(distances);
    if (distance < smallest) {
      smallest = distance;
      best = i;
    }
  }
  return all[best];
}

BoardProblem start_problem(const CalibrationInput& input, LensModel model) {
  const OneCamera left = fit_one_camera(input, 0, model);
  BoardProblem problem{input.board, {left.lens}, {}, std::vector<SE3>(input.frames.size()), {}, {}};
  OneCamera right;
  if (input.stereo) {
    right = fit_one_camera(input, 1, model);
    problem.lenses.push_back(right.lens);
    problem.right_from_left = median_right_from_left(left, right);
  }
  for (const BoardView& view : input.views) {
    const auto in_left = left.camera_from_board.find(view.frame);
    const auto in_right = right.camera_from_board.find(view.frame);
    if (in_left == left.camera_from_board.end() && in_right == right.camera_from_board.end()) continue;
    problem.views.push_back(view);
    problem.left_from_board[static_cast<std::size_t>(view.frame)] =
        in_left != left.camera_from_board.end() ? in_left->second
                                                : problem.right_from_left.inverse() * in_right->second;
  }
  return problem;
}

/// Leaves out views and corners that fit far worse than the others; false if there are none.
bool leave_out(BoardSolution& solution, const CalibrationOptions& options, CameraCalibration& calibration) {
  std::vector<double> errors, coordinates;
  for (const auto& residuals : solution.residuals) {
    errors.push_back(rms_of_view(residuals));
    for (const Eigen::Vector2d& residual : residuals) {
      coordinates.push_back(std::abs(residual.x()));
      coordinates.push_back(std::abs(residual.y()));
    }
  }
  const double worst_frame = options.bad_frame * median_of(errors) + 1e-6;
  const double worst_corner = options.outlier_sigmas * 1.4826 * median_of(coordinates) + 1e-6;
  std::vector<BoardView> kept;
  bool changed = false;
  for (std::size_t v = 0; v < solution.problem.views.size(); ++v) {
    const BoardView& view = solution.problem.views[v];
    BoardView good{view.frame, view.camera, {}, {}};
    std::vector<Eigen::Vector2d> fitting;
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (solution.residuals[v][i].lpNorm<Eigen::Infinity>() > worst_corner) continue;
      good.corners.push_back(view.corners[i]);
      good.pixels.push_back(view.pixels[i]);
      fitting.push_back(solution.residuals[v][i]);
    }
    const std::size_t all = view.corners.size();
    if (rms_of_view(fitting) > worst_frame || 2 * good.corners.size() < all || good.corners.size() < 4) {
      calibration.frames_left_out.push_back({view.frame, view.camera, errors[v]});
      changed = true;
      continue;
    }
    calibration.corners_left_out += static_cast<int>(all - good.corners.size());
    changed = changed || good.corners.size() < all;
    kept.push_back(std::move(good));
  }
  solution.problem.views = std::move(kept);
  return changed;
}

void require_views(const BoardProblem& problem) {
  for (int camera = 0; camera < static_cast<int>(problem.lenses.size()); ++camera) {
    const auto count = std::count_if(problem.views.begin(), problem.views.end(),
                                     [&](const BoardView& view) { return view.camera == camera; });
    if (count < fewest_frames)
      throw Error("fewer than 3 images agree on one camera", camera == 0 ? "DATA" : "--right",
                  "take more images of a flat board");
  }
}

constexpr LensModel all_models[] = {LensModel::pinhole_4, LensModel::pinhole_5, LensModel::equidistant,
                                    LensModel::pinhole_8};

std::vector<LensModel> models_to_fit(const CalibrationOptions& options) {
  if (options.compare_models) return {std::begin(all_models), std::end(all_models)};
  return {options.model.value_or(LensModel::pinhole_5)};
}

BoardProblem as_model(BoardProblem problem, LensModel model) {
  for (Lens& lens : problem.lenses) lens = as_model(lens, model);
  return problem;
}

BoardAdjustmentOptions robust_options() {
  BoardAdjustmentOptions robust;
  robust.free_bow = true;
  robust.huber_px = huber_px;
  robust.iterations = 40;
  return robust;
}

/// Fits with all views, robust to those that are wrong, from which all others start.
std::map<LensModel, BoardSolution> first_fits(const CalibrationInput& input, const std::vector<LensModel>& models) {
  const auto wanted = [&](LensModel model) { return std::find(models.begin(), models.end(), model) != models.end(); };
  std::map<LensModel, BoardSolution> fits;
  const auto fit = [&](LensModel model, const BoardProblem& start) {
    fits.emplace(model, adjust_boards(start, robust_options()));
  };
  if (wanted(LensModel::equidistant)) fit(LensModel::equidistant, start_problem(input, LensModel::equidistant));
  if (models.size() == 1 && models.front() == LensModel::equidistant) return fits;
  fit(LensModel::pinhole_5, start_problem(input, LensModel::pinhole_5));
  const BoardProblem& five = fits.at(LensModel::pinhole_5).problem;
  if (wanted(LensModel::pinhole_8)) fit(LensModel::pinhole_8, as_model(five, LensModel::pinhole_8));
  return fits;
}

double typical_error(const BoardSolution& solution) {
  std::vector<double> errors;
  for (const auto& residuals : solution.residuals)
    for (const Eigen::Vector2d& residual : residuals) errors.push_back(residual.norm());
  return median_of(errors);
}

/// Poses anew, with the lens that was found, for frames that fit badly: the first lens may have put them on a wrong
/// side. Returns whether there were any.
bool restart_bad_frames(BoardSolution& solution, double bad_frame) {
  std::vector<double> errors;
  for (const auto& residuals : solution.residuals) errors.push_back(rms_of_view(residuals));
  const double worst = bad_frame * median_of(errors) + 1e-6;
  BoardProblem& problem = solution.problem;
  bool any = false;
  for (std::size_t v = 0; v < errors.size(); ++v) {
    if (errors[v] <= worst) continue;
    const BoardView& view = problem.views[v];
    const auto pose = board_pose(problem.board, view, problem.lenses[static_cast<std::size_t>(view.camera)]);
    if (!pose) continue;
    problem.left_from_board[static_cast<std::size_t>(view.frame)] =
        view.camera == 0 ? *pose : problem.right_from_left.inverse() * *pose;
    any = true;
  }
  return any;
}

/// The views that fit. The model that fits best says which, or a lens that a simple model cannot have would cost good
/// views.
BoardProblem good_views(const std::map<LensModel, BoardSolution>& fits, const CalibrationOptions& options,
                        CameraCalibration& calibration) {
  const auto best = std::min_element(fits.begin(), fits.end(), [](const auto& a, const auto& b) {
    return typical_error(a.second) < typical_error(b.second);
  });
  BoardSolution solution = best->second;
  for (int round = 0; round < 2 && restart_bad_frames(solution, options.bad_frame); ++round)
    solution = adjust_boards(solution.problem, robust_options());
  for (int round = 0; round < 5 && leave_out(solution, options, calibration); ++round) {
    require_views(solution.problem);
    solution = adjust_boards(solution.problem, robust_options());
  }
  require_views(solution.problem);
  return solution.problem;
}

/// Least squares fits of all models to the same good views.
std::map<LensModel, BoardSolution> fit_models(const CalibrationInput& input, const CalibrationOptions& options,
                                              CameraCalibration& calibration) {
  const std::vector<LensModel> models = models_to_fit(options);
  const std::map<LensModel, BoardSolution> starts = first_fits(input, models);
  const BoardProblem good = good_views(starts, options, calibration);
  BoardAdjustmentOptions adjust;
  adjust.free_bow = true;
  std::map<LensModel, BoardSolution> fits;
  for (const LensModel model : models) {
    const auto own = starts.find(model);
    BoardProblem problem =
        own != starts.end() ? own->second.problem : as_model(starts.at(LensModel::pinhole_5).problem, model);
    std::vector<bool> started(problem.left_from_board.size(), false);
    for (const BoardView& view : problem.views) started[static_cast<std::size_t>(view.frame)] = true;
    for (std::size_t frame = 0; frame < started.size(); ++frame)
      if (!started[frame]) problem.left_from_board[frame] = good.left_from_board[frame];
    if (good.lenses.front().model == model) problem = good;
    problem.views = good.views;
    fits.emplace(model, adjust_boards(problem, adjust));
  }
  return fits;
}

double bayes_criterion(const BoardSolution& solution) {
  const double n = solution.measurements;
  return n * std::log(std::max(1e-12, solution.squared_error) / n) + solution.parameters.count * std::log(n);
}

/// The problem with the views of even or odd frames only, counted among those in use.
BoardProblem half_of(const BoardProblem& problem, int which) {
  std::map<int, int> number;
  for (const BoardView& view : problem.views) number[view.frame] = 0;
  int next = 0;
  for (auto& [frame, n] : number) n = next++;
  BoardProblem half = problem;
  std::erase_if(half.views, [&](const BoardView& view) { return number[view.frame] % 2 != which; });
  return half;
}

BoardAdjustmentOptions same_freedom(const BoardSolution& solution) {
  BoardAdjustmentOptions options;
  options.free_bow = solution.parameters.bow >= 0;
  options.free_stretch = solution.parameters.stretch >= 0;
  return options;
}

int frames_in_use(const BoardProblem& problem) {
  std::map<int, int> frames;
  for (const BoardView& view : problem.views) ++frames[view.frame];
  return static_cast<int>(frames.size());
}

std::vector<BoardSolution> fit_halves(const BoardSolution& solution) {
  std::vector<BoardSolution> halves;
  if (frames_in_use(solution.problem) < fewest_for_halves) return halves;
  for (int which = 0; which < 2; ++which)
    halves.push_back(adjust_boards(half_of(solution.problem, which), same_freedom(solution)));
  for (const BoardSolution& half : halves)
    if (std::min(half.parameters.lenses.front(), half.parameters.lenses.back()) < 0 || half.degrees_of_freedom() < 1)
      return {};
  return halves;
}

/// Each half's boards seen with the lens of the other, whose poses alone are estimated.
double holdout_of(const std::vector<BoardSolution>& halves) {
  if (halves.size() < 2) return 0.0;
  double squared = 0.0;
  int measurements = 0;
  for (int which = 0; which < 2; ++which) {
    BoardProblem other = halves[static_cast<std::size_t>(1 - which)].problem;
    const BoardProblem& used = halves[static_cast<std::size_t>(which)].problem;
    other.lenses = used.lenses;
    other.right_from_left = used.right_from_left;
    other.shape = used.shape;
    BoardAdjustmentOptions poses_only;
    poses_only.free_lenses = false;
    const BoardSolution fit = adjust_boards(other, poses_only);
    squared += fit.squared_error;
    measurements += fit.measurements;
  }
  return std::sqrt(2.0 * squared / std::max(1, measurements));
}

/// Fills in the models, simplest first, and chooses the simplest one that no other beats by much: by the criterion of
/// Bayes, and in the frames held out, which are fitted only where that matters.
LensModel choose_model(const std::map<LensModel, BoardSolution>& fits, bool compare, std::vector<ModelFit>& models) {
  models.clear();
  std::size_t best = 0;
  const auto hold_out = [&](ModelFit& fit) {
    if (compare && fit.holdout_px == 0.0) fit.holdout_px = holdout_of(fit_halves(fits.at(fit.model)));
    return fit.holdout_px;
  };
  for (const auto& [model, fit] : fits) models.push_back({model, fit.rms_px(), 0.0, bayes_criterion(fit)});
  for (std::size_t k = 1; k < models.size(); ++k)
    if (models[k].bic < models[best].bic - 10.0 && models[k].rms_px < 0.995 * models[best].rms_px &&
        hold_out(models[k]) <= hold_out(models[best]))
      best = k;
  return models[best].model;
}

/// Whether the freer one of two fits is better beyond chance (F test) and by what matters.
bool better_with(const BoardSolution& freer, const BoardSolution& plain, int parameters) {
  const double noise = std::max(1e-12, freer.squared_error) / std::max(1, freer.degrees_of_freedom());
  const double f = (plain.squared_error - freer.squared_error) / parameters / noise;
  return f > 20.0 && plain.rms_px() > 1.01 * freer.rms_px();
}

ShapeFinding find_shape(const BoardSolution& bow_free) {
  const LensModel model = bow_free.problem.lenses.front().model;
  ShapeFinding finding;
  const BoardSolution flat = refit(bow_free, model, false, false);
  finding.bowed = better_with(bow_free, flat, 2);
  const BoardSolution& plain = finding.bowed ? bow_free : flat;
  const BoardSolution all_free = refit(bow_free, model, true, true);
  const BoardSolution stretched = finding.bowed ? all_free : refit(bow_free, model, false, true);
  finding.stretched = better_with(stretched, plain, 1);
  const BoardShape& shape = all_free.problem.shape;
  finding.bow_x_m = shape.bow_x_m;
  finding.bow_y_m = shape.bow_y_m;
  finding.stretch_y = shape.stretch_y;
  if (const auto covariance = board_covariance(all_free)) {
    const int at = all_free.parameters.bow + (std::abs(shape.bow_y_m) > std::abs(shape.bow_x_m) ? 1 : 0);
    finding.bow_sigma_m = all_free.noise_px() * std::sqrt((*covariance)(at, at));
    const int stretch = all_free.parameters.stretch;
    finding.stretch_sigma = all_free.noise_px() * std::sqrt((*covariance)(stretch, stretch));
  }
  return finding;
}

void finish(CameraCalibration& calibration, bool halves) {
  const auto scaled = [](const BoardSolution& solution) {
    auto covariance = board_covariance(solution);
    if (covariance) *covariance *= solution.noise_px() * solution.noise_px();
    return covariance;
  };
  const auto covariance = scaled(calibration.solution);
  if (!covariance || !(calibration.solution.noise_px() < 1e3))
    throw Error("the views do not determine the camera", "DATA",
                "take images of the board from several distances and tilted by 20 to 45 degrees in each direction");
  calibration.covariance = *covariance;
  calibration.halves.clear();
  calibration.half_covariances.clear();
  calibration.holdout_px = 0.0;
  if (!halves) return;
  calibration.halves = fit_halves(calibration.solution);
  calibration.holdout_px = holdout_of(calibration.halves);
  for (const BoardSolution& half : calibration.halves) {
    const auto half_covariance = scaled(half);
    if (half_covariance) calibration.half_covariances.push_back(*half_covariance);
  }
  if (calibration.half_covariances.size() < calibration.halves.size()) {
    calibration.halves.clear();
    calibration.half_covariances.clear();
  }
}

}  // namespace

Eigen::VectorXd CameraCalibration::lens_sigmas(std::size_t camera) const {
  const Eigen::Index size = solution.problem.lenses[camera].parameters.size();
  return covariance.diagonal().segment(solution.parameters.lenses[camera], size).cwiseMax(0.0).cwiseSqrt();
}

BoardSolution refit(const BoardSolution& solution, LensModel model, bool free_bow, bool free_stretch) {
  BoardProblem problem = solution.problem;
  for (Lens& lens : problem.lenses) lens = as_model(lens, model);
  if (!free_bow) problem.shape.bow_x_m = problem.shape.bow_y_m = 0.0;
  if (!free_stretch) problem.shape.stretch_y = 0.0;
  BoardAdjustmentOptions options;
  options.free_bow = free_bow;
  options.free_stretch = free_stretch;
  return adjust_boards(problem, options);
}

CameraCalibration calibrate_camera(const CalibrationInput& input, const CalibrationOptions& options) {
  if (input.width <= 0 || input.height <= 0) throw Error("images without a size", "DATA", "");
  CameraCalibration calibration;
  std::map<LensModel, BoardSolution> fits = fit_models(input, options, calibration);
  calibration.best_model = choose_model(fits, options.compare_models, calibration.models);
  calibration.shape = find_shape(fits.at(calibration.best_model));
  if (calibration.shape.stretched) {
    // A lens with more coefficients may only have made up for the board.
    for (auto& [model, fit] : fits) fit = refit(fit, model, true, true);
    calibration.best_model = choose_model(fits, options.compare_models, calibration.models);
    const LensModel best = calibration.best_model;
    calibration.shape = find_shape(refit(fits.at(best), best, true, false));
  }
  const LensModel chosen = options.model.value_or(calibration.best_model);
  calibration.solution = refit(fits.at(chosen), chosen, calibration.shape.bowed, calibration.shape.stretched);
  finish(calibration, options.compare_models);
  return calibration;
}

}  // namespace rastro
