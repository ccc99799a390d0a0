// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/depth_calibration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/camera/write_calibration.h"

namespace rastro {
namespace {

constexpr int readings_a_view = 600;
constexpr int fewest_readings = 30;
constexpr int fewest_views = 3;
/// Shares of the distance: how far off the board's plane a reading may be to be of the board, before and after the
/// first fit.
constexpr double first_gate = 0.12, later_gate = 0.04;
constexpr double huber_sigmas = 2.0;

/// Parameters: scale - 1, offset, rotation from the left, translation.
using Vector8 = Eigen::Matrix<double, 8, 1>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;

struct Model {
  double scale = 1.0, offset_m = 0.0;
  SE3 color_from_depth;

  Eigen::Vector3d point(const Eigen::Vector3d& ray, double depth) const {
    return color_from_depth * (ray * (scale * depth + offset_m));
  }
};

struct Reading {
  Eigen::Vector3d ray;  ///< z is 1, in the depth camera.
  double depth = 0.0;
};

struct Plane {
  Eigen::Vector3d normal;
  double distance = 0.0;  ///< normal . point of it.
};

struct View {
  Plane plane;
  std::vector<Reading> readings;
  double depth = 0.0;  ///< Median.
};

/// How far a reading is behind the board along its ray, meters, with the derivatives by the parameters.
double off_plane(const Model& model, const View& view, const Reading& reading, Vector8* by) {
  const Eigen::Vector3d turned = model.color_from_depth.rotation() * reading.ray;
  const double slope = view.plane.normal.dot(turned);
  const Eigen::Vector3d point = model.point(reading.ray, reading.depth);
  const double off = view.plane.normal.dot(point) - view.plane.distance;
  if (by != nullptr) {
    (*by)[0] = reading.depth;
    (*by)[1] = 1.0;
    const Eigen::Vector3d arm = point - model.color_from_depth.translation();
    by->segment<3>(2) = arm.cross(view.plane.normal) / slope;
    by->segment<3>(5) = view.plane.normal / slope;
  }
  return off / slope;
}

/// Readings on the board as the model has it, on a grid of pixels.
View readings_of(const DepthCalibrationInput& input, const Image<float>& rays_x, const Image<float>& rays_y,
                 const DepthView& seen, const Model& model, double gate) {
  View view;
  view.plane.normal = seen.color_from_board.rotation() * Eigen::Vector3d::UnitZ();
  view.plane.distance = view.plane.normal.dot(seen.color_from_board.translation());
  const SE3 board_from_color = seen.color_from_board.inverse();
  const DepthImage& depth = *seen.depth;
  std::vector<Reading> all;
  for (int y = 0; y < depth.height(); y += 2)
    for (int x = 0; x < depth.width(); x += 2) {
      const double z = static_cast<double>(depth.at(x, y));
      if (!(z > 0.05 && z < 100.0) || std::isnan(rays_x.at(x, y))) continue;
      const Eigen::Vector3d ray(rays_x.at(x, y), rays_y.at(x, y), 1.0);
      const Eigen::Vector3d on_board = board_from_color * model.point(ray, z);
      if (std::abs(on_board.z()) > gate * z) continue;
      if ((on_board.head<2>().array() < input.low.array()).any() ||
          (on_board.head<2>().array() > input.high.array()).any())
        continue;
      all.push_back({ray, z});
    }
  const std::size_t step = std::max<std::size_t>(1, all.size() / readings_a_view);
  std::vector<double> depths;
  for (std::size_t k = 0; k < all.size(); k += step) {
    view.readings.push_back(all[k]);
    depths.push_back(all[k].depth);
  }
  if (!depths.empty()) {
    std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
    view.depth = depths[depths.size() / 2];
  }
  return view;
}

double robust_spread(std::vector<double> values) {
  if (values.empty()) return 0.0;
  for (double& value : values) value = std::abs(value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return 1.4826 * *middle;
}

struct Noise {
  double sigma_m = 0.0, sigma_per_m2 = 0.0;
  double at(double z) const { return sigma_m + sigma_per_m2 * z * z; }
};

/// Both at least 0, from the spread at each board, whose relative errors are alike.
Noise fit_noise(const Model& model, const std::vector<View>& views) {
  std::vector<Eigen::Vector2d> rows;  // Square of the depth, spread.
  for (const View& view : views) {
    std::vector<double> off;
    for (const Reading& reading : view.readings) off.push_back(off_plane(model, view, reading, nullptr));
    rows.emplace_back(view.depth * view.depth, std::max(1e-6, robust_spread(off)));
  }
  Noise noise;
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows.size()));
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Eigen::Vector2d by(1.0, rows[i].x());
      normal += weight[static_cast<Eigen::Index>(i)] * by * by.transpose();
      right += weight[static_cast<Eigen::Index>(i)] * by * rows[i].y();
    }
    const Eigen::Vector2d both = normal.ldlt().solve(right);
    noise = {both[0], both[1]};
    if (!(noise.sigma_per_m2 >= 0.0)) noise = {right[0] / normal(0, 0), 0.0};
    if (!(noise.sigma_m >= 0.0)) noise = {0.0, right[1] / normal(1, 1)};
    for (std::size_t i = 0; i < rows.size(); ++i)
      weight[static_cast<Eigen::Index>(i)] = 1.0 / std::pow(std::max(1e-6, noise.at(std::sqrt(rows[i].x()))), 2);
  }
  return noise;
}

struct Fit {
  Model model;
  Matrix8 covariance = Matrix8::Zero();
};

/// Gauss-Newton, Huber's kernel, with rotation and translation held unless `free_pose`. The covariance is that of
/// readings which share errors within a board (the sandwich of Liang and Zeger 1986).
Fit fit_model(Model model, const std::vector<View>& views, const Noise& noise, bool free_pose) {
  const int size = free_pose ? 8 : 2;
  Fit fit{model};
  for (int round = 0; round < 15; ++round) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size), scatter = normal;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    for (const View& view : views) {
      Eigen::VectorXd of_view = Eigen::VectorXd::Zero(size);
      for (const Reading& reading : view.readings) {
        Vector8 by;
        const double off = off_plane(fit.model, view, reading, &by);
        const double sigma = std::max(1e-5, noise.at(reading.depth)), normalized = std::abs(off) / sigma;
        const double weight = (normalized > huber_sigmas ? huber_sigmas / normalized : 1.0) / (sigma * sigma);
        normal += weight * by.head(size) * by.head(size).transpose();
        of_view += weight * off * by.head(size);
      }
      right += of_view;
      scatter += of_view * of_view.transpose();
    }
    const Eigen::MatrixXd inverse = normal.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
    const Eigen::VectorXd step = -inverse * right;
    const double correction =
        static_cast<double>(views.size()) / std::max(1.0, static_cast<double>(views.size()) - size);
    fit.covariance.topLeftCorner(size, size) = correction * inverse * scatter * inverse;
    if (!step.allFinite()) break;
    fit.model.scale += step[0];
    fit.model.offset_m += step[1];
    if (free_pose) {
      const SE3& pose = fit.model.color_from_depth;
      fit.model.color_from_depth = {SO3::exp(step.segment<3>(2)) * pose.rotation(),
                                    pose.translation() + step.tail<3>()};
    }
    if (step.norm() < 1e-10) break;
  }
  return fit;
}

std::vector<View> collect(const DepthCalibrationInput& input, const Model& model, double gate) {
  const Camera& camera = input.depth_camera;
  Image<float> rays_x(camera.width, camera.height), rays_y(camera.width, camera.height);
  for (int y = 0; y < camera.height; y += 2)
    for (int x = 0; x < camera.width; x += 2) {
      const auto ray = camera.unproject({static_cast<double>(x), static_cast<double>(y)});
      rays_x.at(x, y) = ray ? static_cast<float>(ray->x()) : std::nanf("");
      rays_y.at(x, y) = ray ? static_cast<float>(ray->y()) : std::nanf("");
    }
  std::vector<View> views;
  for (const DepthView& seen : input.views) {
    if (seen.depth == nullptr || seen.depth->width() != camera.width || seen.depth->height() != camera.height) continue;
    View view = readings_of(input, rays_x, rays_y, seen, model, gate);
    if (static_cast<int>(view.readings.size()) >= fewest_readings) views.push_back(std::move(view));
  }
  return views;
}

void require_distances(const std::vector<View>& views) {
  if (static_cast<int>(views.size()) < fewest_views)
    throw Error("depth was measured on " + std::to_string(views.size()) + " boards", "DATA",
                "at least 3 are needed, better 20: is the depth of the same instant, and registered to color?");
  const auto [nearest, farthest] =
      std::minmax_element(views.begin(), views.end(), [](const View& a, const View& b) { return a.depth < b.depth; });
  if (farthest->depth < 1.15 * nearest->depth)
    throw Error("all boards are at one distance", "DATA",
                "scale and offset of depth need boards from near to twice as far");
}

void judge(const Fit& free, bool registered, DepthCalibration& result) {
  const double turned = free.model.color_from_depth.rotation().log().norm();
  const double moved = free.model.color_from_depth.translation().norm();
  if (registered && (turned > std::max(4.0 * result.rotation_sigma_rad, 0.003) ||
                     moved > std::max(4.0 * result.translation_sigma_m, 0.005)))
    result.doubts.push_back(
        fmt::format("depth is not registered to color: it is turned by {:.2f} degrees and moved by {:.1f} mm",
                    turned * 57.29578, moved * 1e3));
  if (std::abs(result.scale - 1.0) > std::max(4.0 * result.scale_sigma, 0.002))
    result.doubts.push_back(fmt::format("depth is {:.2f} % too {}: correct it by the scale",
                                        100.0 * std::abs(1.0 / result.scale - 1.0),
                                        result.scale < 1.0 ? "large" : "small"));
  if (result.scale > largest_depth_correction || result.scale < 1.0 / largest_depth_correction)
    result.doubts.push_back(
        fmt::format("the unit of the readings is another: a depth_factor that corrects more than "
                    "{:.0f} % is used by recordings in TUM layout alone",
                    100.0 * (largest_depth_correction - 1.0)));
  if (result.farthest_m < 2.0 * result.nearest_m)
    result.doubts.emplace_back("missing: boards at twice the distance, to tell scale and offset of depth apart");
}

}  // namespace

DepthCalibration calibrate_depth(const DepthCalibrationInput& input) {
  Model model;
  model.color_from_depth = input.color_from_depth;
  Noise noise{0.01, 0.0};
  std::vector<View> views = collect(input, model, first_gate);
  require_distances(views);
  Fit fit{model};
  for (int round = 0; round < 3; ++round) {
    fit = fit_model(fit.model, views, noise, !input.registered);
    views = collect(input, fit.model, later_gate);
    require_distances(views);
    noise = fit_noise(fit.model, views);
  }
  fit = fit_model(fit.model, views, noise, !input.registered);
  const Fit free = input.registered ? fit_model(fit.model, views, noise, true) : fit;
  const Vector8 sigmas = fit.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Vector8 free_sigmas = free.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  DepthCalibration result;
  result.views = static_cast<int>(views.size());
  result.nearest_m = 1e9;
  for (const View& view : views) {
    result.readings += static_cast<int>(view.readings.size());
    result.nearest_m = std::min(result.nearest_m, view.depth);
    result.farthest_m = std::max(result.farthest_m, view.depth);
  }
  result.scale = fit.model.scale;
  result.scale_sigma = std::hypot(sigmas[0], result.scale * input.focal_length_sigma);
  result.offset_m = fit.model.offset_m;
  result.offset_sigma_m = sigmas[1];
  result.sigma_m = noise.sigma_m;
  result.sigma_per_m2 = noise.sigma_per_m2;
  result.color_from_depth = free.model.color_from_depth;
  result.rotation_sigma_rad = free_sigmas.segment<3>(2).maxCoeff();
  result.translation_sigma_m = free_sigmas.tail<3>().maxCoeff();
  if (!input.registered) result.depth_camera = input.depth_camera;
  judge(free, input.registered, result);
  return result;
}

std::string depth_summary(const DepthCalibration& calibration) {
  std::string text = fmt::format(
      "depth, from {} boards at {:.2f} to {:.2f} m\n  scale     {:.5f} +- {:.5f}\n  offset    {:.2f} +- {:.2f} mm\n"
      "  noise     {:.2f} mm + {:.2f} mm/m2 * depth^2\n  to color  turned by {:.3f} +- {:.3f} degrees, moved by {:.1f} "
      "+- {:.1f} mm\n",
      calibration.views, calibration.nearest_m, calibration.farthest_m, calibration.scale, calibration.scale_sigma,
      calibration.offset_m * 1e3, calibration.offset_sigma_m * 1e3, calibration.sigma_m * 1e3,
      calibration.sigma_per_m2 * 1e3, calibration.color_from_depth.rotation().log().norm() * 57.29578,
      calibration.rotation_sigma_rad * 57.29578, calibration.color_from_depth.translation().norm() * 1e3,
      calibration.translation_sigma_m * 1e3);
  for (const std::string& line : calibration.doubts) text += fmt::format("  - {}\n", line);
  return text;
}

std::string depth_calibration_text(const DepthCalibration& calibration, const DepthAsRead& read) {
  std::string text =
      fmt::format("depth_factor: {:.10g}\ndepth_offset_m: {:.6g}\ndepth_sigma_m: {:.6g}\ndepth_sigma_per_m2: {:.6g}\n",
                  read.units_per_meter / calibration.scale, calibration.scale * read.offset_m + calibration.offset_m,
                  calibration.sigma_m, calibration.sigma_per_m2);
  if (calibration.depth_camera)
    text += depth_registration_text({*calibration.depth_camera, calibration.color_from_depth});
  else if (read.registration)
    text += depth_registration_text(*read.registration);
  return text;
}

}  // namespace rastro
