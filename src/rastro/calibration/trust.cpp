// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/trust.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace rastro {
namespace {

constexpr int cells_a_side = BoardCoverage::cells_a_side;
constexpr double wanted_tilt_deg = BoardCoverage::wanted_tilt_deg;

double median_of_map(const ImageMap& map) {
  std::vector<double> values;
  for (const double value : map.values)
    if (std::isfinite(value)) values.push_back(value);
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

double largest_of_map(const ImageMap& map) {
  double largest = 0.0;
  for (const double value : map.values)
    if (std::isfinite(value)) largest = std::max(largest, value);
  return largest;
}

constexpr int ninths = BoardCoverage::ninths_a_side;

/// Of the ninths of the image, row by row: those without a corner in most of their cells.
std::array<bool, ninths * ninths> empty_ninths(const std::array<bool, cells_a_side * cells_a_side>& seen) {
  std::array<bool, ninths * ninths> empty{};
  for (int y = 0; y < ninths; ++y)
    for (int x = 0; x < ninths; ++x) {
      int with = 0;
      for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx)
          with += seen[static_cast<std::size_t>((2 * y + dy) * cells_a_side + 2 * x + dx)] ? 1 : 0;
      empty[static_cast<std::size_t>(y * ninths + x)] = with < 2;
    }
  return empty;
}

/// Whether the outermost cells of a side have no corner; sides in the order left, right, upper, lower.
bool edge_empty(const std::array<bool, cells_a_side * cells_a_side>& seen, std::size_t side) {
  constexpr std::size_t last = cells_a_side - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    const std::size_t x = side == 0 ? 0 : side == 1 ? last : k;
    const std::size_t y = side == 2 ? 0 : side == 3 ? last : k;
    if (seen[y * cells_a_side + x]) return false;
  }
  return true;
}

/// Whole sides by one name, the ninths beside them by their own; edges where the side behind them was seen.
void name_missing_regions(BoardCoverage& coverage) {
  constexpr const char* names[] = {"upper left", "top",        "upper right", "left",       "center",
                                   "right",      "lower left", "bottom",      "lower right"};
  struct Side {
    const char *name, *edge;
    std::array<std::size_t, 3> parts;
  };
  constexpr Side sides[] = {{"the whole left side", "the left edge", {0, 3, 6}},
                            {"the whole right side", "the right edge", {2, 5, 8}},
                            {"the whole upper side", "the upper edge", {0, 1, 2}},
                            {"the whole lower side", "the lower edge", {6, 7, 8}}};
  const auto& empty = coverage.empty = empty_ninths(coverage.seen);
  auto unnamed = empty;
  int whole = 0;
  for (std::size_t side = 0; side < std::size(sides); ++side) {
    const auto& [name, edge, parts] = sides[side];
    coverage.empty_edges[side] = edge_empty(coverage.seen, side);
    if (!std::all_of(parts.begin(), parts.end(), [&](std::size_t k) { return empty[k]; })) {
      if (coverage.empty_edges[side]) coverage.missing.emplace_back(edge);
      continue;
    }
    coverage.missing.emplace_back(name);
    for (const std::size_t k : parts) unnamed[k] = false;
    ++whole;
  }
  if (whole == 4) {
    coverage.missing = {unnamed[4] ? "the whole image" : "everything but the center"};
    unnamed[4] = false;
  }
  for (std::size_t k = 0; k < unnamed.size(); ++k)
    if (unnamed[k]) coverage.missing.emplace_back(names[k]);
}

void name_missing_tilts(BoardCoverage& coverage) {
  const double* tilt = coverage.largest_tilt_deg;
  coverage.lacks_tilt_sideways = std::max(tilt[0], tilt[1]) < wanted_tilt_deg;
  coverage.lacks_tilt_up_down = std::max(tilt[2], tilt[3]) < wanted_tilt_deg;
  if (coverage.lacks_tilt_sideways && coverage.lacks_tilt_up_down) {
    coverage.missing.emplace_back("tilted boards");
  } else if (coverage.lacks_tilt_sideways) {
    coverage.missing.emplace_back("boards tilted to the left or right");
  } else if (coverage.lacks_tilt_up_down) {
    coverage.missing.emplace_back("boards tilted up or down");
  }
}

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

void doubt(CalibrationTrust& trust, Trust level, std::string line) {
  trust.trust = std::max(trust.trust, level);
  trust.doubts.push_back(std::move(line));
}

const ModelFit* fit_of(const CameraCalibration& calibration, LensModel model) {
  for (const ModelFit& fit : calibration.models)
    if (fit.model == model) return &fit;
  return nullptr;
}

void doubt_model(const CameraCalibration& calibration, CalibrationTrust& trust) {
  const LensModel used = calibration.solution.problem.lenses.front().model;
  const ModelFit* fit = fit_of(calibration, used);
  const ModelFit* best = fit_of(calibration, calibration.best_model);
  if (fit == nullptr || best == nullptr || best == fit) return;
  if (best->rms_px > 0.97 * fit->rms_px) return;
  doubt(trust, best->rms_px < 0.8 * fit->rms_px ? Trust::bad : Trust::usable,
        fmt::format("the model is too simple: {} leaves {:.3f} px, {} {:.3f} px", lens_model_name(used), fit->rms_px,
                    lens_model_name(best->model), best->rms_px));
}

void doubt_shape(const ShapeFinding& shape, CalibrationTrust& trust) {
  if (shape.bowed)
    doubt(trust, Trust::usable,
          fmt::format(
              "the board is not flat: its middle stands out by {:.2f} mm along x and {:.2f} mm along y, +- {:.2f} mm; "
              "this was estimated and taken out",
              shape.bow_x_m * 1e3, shape.bow_y_m * 1e3, shape.bow_sigma_m * 1e3));
  if (shape.stretched)
    doubt(trust, Trust::usable,
          fmt::format(
              "the squares are not square: {:.2f} +- {:.2f} % higher than wide; this was estimated and taken out, "
              "but one of the sides is not what --board says",
              shape.stretch_y * 1e2, shape.stretch_sigma * 1e2));
}

void doubt_halves(const CrossValidation& halves, bool explained, CalibrationTrust& trust) {
  if (!halves.done) {
    doubt(trust, Trust::usable, "too few images to check one half against the other: take 20 or more");
  } else if (!halves.agree) {
    doubt(trust, halves.difference_px > 1.0 ? Trust::bad : Trust::usable,
          fmt::format(
              "two halves of the images differ by {:.2f} px where noise explains {:.2f} px{}", halves.difference_px,
              halves.expected_px,
              explained ? ""
                        : ": the board moved or blurred while it was taken, is not flat, or the model is too simple"));
  }
}

/// Projections at places of the image that both halves have: their difference, and how it is spread by noise.
struct HalvesInImage {
  double squared_px = 0.0;     ///< Sum over the places.
  Eigen::MatrixXd by_a, by_b;  ///< Derivatives of the projections by the parameters of each half, two rows a place.
};

HalvesInImage halves_in_image(const CameraCalibration& calibration, std::size_t camera, int width, int height) {
  const BoardSolution &a = calibration.halves[0], &b = calibration.halves[1];
  const ProjectionDifference difference =
      projection_difference(a.problem.lenses[camera], b.problem.lenses[camera], width, height, 16);
  const Eigen::Index most = 2 * difference.x.columns * difference.x.rows;
  HalvesInImage halves{0.0, Eigen::MatrixXd(most, a.parameters.count), Eigen::MatrixXd(most, b.parameters.count)};
  Eigen::Index rows = 0;
  for (int row = 0; row < difference.x.rows; ++row)
    for (int column = 0; column < difference.x.columns; ++column) {
      const Eigen::Vector2d pixel = map_pixel(difference.x, column, row, width, height);
      const auto by_a = projection_by_parameters(a, camera, pixel, 0.0);
      const auto by_b = projection_by_parameters(b, camera, pixel, 0.0);
      const double x = difference.x.at(column, row), y = difference.y.at(column, row);
      if (!by_a || !by_b || !std::isfinite(x) || !std::isfinite(y)) continue;
      halves.squared_px += x * x + y * y;
      halves.by_a.middleRows<2>(rows) = *by_a;
      halves.by_b.middleRows<2>(rows) = *by_b;
      rows += 2;
    }
  halves.by_a.conservativeResize(rows, Eigen::NoChange);
  halves.by_b.conservativeResize(rows, Eigen::NoChange);
  return halves;
}

/// By how much the root of a mean of squares may exceed what is expected of it, at 1 in 1000, where it has so many
/// degrees of freedom (Wilson and Hilferty 1931).
double most_by_chance(double freedom) {
  const double spread = 2.0 / (9.0 * freedom);
  return std::sqrt(std::pow(1.0 - spread + 3.09 * std::sqrt(spread), 3));
}

void compare_projections(const CameraCalibration& calibration, std::size_t camera, int width, int height,
                         CrossValidation& result) {
  const HalvesInImage halves = halves_in_image(calibration, camera, width, height);
  const double places = std::max(1.0, 0.5 * static_cast<double>(halves.by_a.rows()));
  const Eigen::MatrixXd covariance = halves.by_a * calibration.half_covariances[0] * halves.by_a.transpose() +
                                     halves.by_b * calibration.half_covariances[1] * halves.by_b.transpose();
  result.difference_px = std::sqrt(halves.squared_px / places);
  result.expected_px = std::sqrt(covariance.trace() / places);
  // Where few boards were, one direction of all parameters may make up most of the difference: the mean over the image
  // then has hardly more than one degree of freedom (Satterthwaite 1946).
  const double freedom = std::max(1.0, std::pow(covariance.trace(), 2) / std::max(1e-300, covariance.squaredNorm()));
  // Corners of one board share blur and shading, which the noise of single corners does not know: so twice is allowed.
  result.agree = result.difference_px <= std::max(2.0, most_by_chance(freedom)) * result.expected_px;
}

}  // namespace

BoardCoverage board_coverage(const BoardSolution& solution, std::size_t camera, int width, int height) {
  BoardCoverage coverage;
  auto& seen = coverage.seen;
  const SE3 from_left = camera == 0 ? SE3() : solution.problem.right_from_left;
  for (const BoardView& view : solution.problem.views) {
    if (static_cast<std::size_t>(view.camera) != camera) continue;
    for (const Eigen::Vector2d& pixel : view.pixels) {
      const int x = std::clamp(static_cast<int>((pixel.x() + 0.5) * cells_a_side / width), 0, cells_a_side - 1);
      const int y = std::clamp(static_cast<int>((pixel.y() + 0.5) * cells_a_side / height), 0, cells_a_side - 1);
      seen[static_cast<std::size_t>(y * cells_a_side + x)] = true;
    }
    const SE3 pose = from_left * solution.problem.left_from_board[static_cast<std::size_t>(view.frame)];
    Eigen::Vector3d normal = pose.rotation() * Eigen::Vector3d::UnitZ();
    if (normal.z() < 0.0) normal = -normal;
    const double x_deg = std::atan2(normal.x(), normal.z()) * 180.0 / std::numbers::pi;
    const double y_deg = std::atan2(normal.y(), normal.z()) * 180.0 / std::numbers::pi;
    double* tilt = coverage.largest_tilt_deg;
    tilt[0] = std::max(tilt[0], -x_deg);
    tilt[1] = std::max(tilt[1], x_deg);
    tilt[2] = std::max(tilt[2], -y_deg);
    tilt[3] = std::max(tilt[3], y_deg);
    const double distance = (pose * board_point(solution.problem, view.corners[view.corners.size() / 2])).norm();
    coverage.nearest_m = coverage.nearest_m == 0.0 ? distance : std::min(coverage.nearest_m, distance);
    coverage.farthest_m = std::max(coverage.farthest_m, distance);
  }
  coverage.image_share =
      static_cast<double>(std::count(seen.begin(), seen.end(), true)) / static_cast<double>(seen.size());
  name_missing_regions(coverage);
  name_missing_tilts(coverage);
  return coverage;
}

CrossValidation cross_validate(const CameraCalibration& calibration, std::size_t camera, int width, int height) {
  CrossValidation result;
  if (calibration.halves.size() < 2) return result;
  result.done = true;
  const BoardSolution &a = calibration.halves[0], &b = calibration.halves[1];
  const Lens &lens_a = a.problem.lenses[camera], &lens_b = b.problem.lenses[camera];
  const Eigen::Index size = lens_a.parameters.size();
  const auto block = [&](const Eigen::MatrixXd& all, const BoardSolution& of) {
    const int at = of.parameters.lenses[camera];
    return Eigen::MatrixXd(all.block(at, at, size, size));
  };
  const Eigen::MatrixXd of_a = block(calibration.half_covariances[0], a),
                        of_b = block(calibration.half_covariances[1], b);
  const Eigen::VectorXd apart = lens_a.parameters - lens_b.parameters;
  const Eigen::MatrixXd both = of_a + of_b;
  const Eigen::VectorXd scale = both.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = scale.asDiagonal() * both * scale.asDiagonal();
  const Eigen::VectorXd scaled = scale.cwiseProduct(apart);
  result.chi_square = scaled.dot(unit.ldlt().solve(scaled)) / static_cast<double>(size);
  compare_projections(calibration, camera, width, height, result);
  return result;
}

CalibrationTrust judge_calibration(const CameraCalibration& calibration, std::size_t camera, int width, int height) {
  CalibrationTrust trust;
  const BoardSolution& solution = calibration.solution;
  trust.coverage = board_coverage(solution, camera, width, height);
  trust.halves = cross_validate(calibration, camera, width, height);
  trust.uncertainty = projection_uncertainty(solution, calibration.covariance, camera, width, height, 0.0);
  trust.uncertainty_median_px = median_of_map(trust.uncertainty);
  trust.uncertainty_largest_px = largest_of_map(trust.uncertainty);
  const double near = 0.5 * (trust.coverage.nearest_m + trust.coverage.farthest_m);
  trust.uncertainty_near_px =
      median_of_map(projection_uncertainty(solution, calibration.covariance, camera, width, height, near, 16));
  if (trust.uncertainty_largest_px > 2.0 || trust.uncertainty_median_px > 0.5)
    doubt(
        trust, trust.uncertainty_median_px > 2.0 ? Trust::bad : Trust::usable,
        fmt::format(
            "projections are uncertain by {:.2f} px in the median and up to {:.1f} px at the worst place of the image",
            trust.uncertainty_median_px, trust.uncertainty_largest_px));
  doubt_model(calibration, trust);
  doubt_shape(calibration.shape, trust);
  doubt_halves(trust.halves, trust.doubts.size() > 0, trust);
  if (!trust.coverage.missing.empty()) doubt(trust, Trust::usable, "missing: " + joined(trust.coverage.missing));
  return trust;
}

void judge_baseline(const CameraCalibration& calibration, double known_m, CalibrationTrust& trust) {
  const int at = calibration.solution.parameters.right_from_left;
  if (at < 0 || !(known_m > 0.0)) return;
  const double found = calibration.solution.problem.right_from_left.inverse().translation().norm();
  const double sigma = std::sqrt(calibration.covariance.diagonal().segment<3>(at + 3).maxCoeff());
  if (std::abs(found - known_m) <= std::max(4.0 * sigma, 0.005 * known_m)) return;
  doubt(trust, Trust::bad,
        fmt::format(
            "wrong square size: the baseline comes out as {:.5f} +- {:.5f} m and is {:.5f} m, so squares are {:.4f} "
            "times as large as --board says",
            found, sigma, known_m, known_m / found));
}

}  // namespace rastro
