// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/lens.h"

#include <ceres/jet.h>

#include <array>

#include "rastro/optimize/lens_projection.h"

namespace rastro {
namespace {

template <LensModel model>
std::optional<Lens::Projection> project_with_derivatives(const Eigen::VectorXd& parameters,
                                                         const Eigen::Vector3d& point) {
  constexpr int size = lens_size(model);
  using Jet = ceres::Jet<double, size + 3>;
  std::array<Jet, size> lens;
  for (int i = 0; i < size; ++i) lens[static_cast<std::size_t>(i)] = Jet(parameters[i], i);
  const std::array<Jet, 3> jets = {Jet(point.x(), size), Jet(point.y(), size + 1), Jet(point.z(), size + 2)};
  std::array<Jet, 2> pixel;
  if (!project_by<model>(lens.data(), jets.data(), pixel.data())) return std::nullopt;
  Lens::Projection result;
  result.pixel = {pixel[0].a, pixel[1].a};
  result.by_parameters.resize(2, size);
  for (int row = 0; row < 2; ++row) {
    const auto& by = pixel[static_cast<std::size_t>(row)].v;
    result.by_parameters.row(row) = by.template head<size>().transpose();
    result.by_point.row(row) = by.template tail<3>().transpose();
  }
  if (!result.pixel.allFinite()) return std::nullopt;
  return result;
}

}  // namespace

std::string_view lens_model_name(LensModel model) {
  constexpr std::array<std::string_view, 4> names = {"pinhole4", "pinhole5", "equidistant", "pinhole8"};
  return names[static_cast<std::size_t>(model)];
}

const std::vector<std::string_view>& lens_parameter_names(LensModel model) {
  static const std::vector<std::string_view> four = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"};
  static const std::vector<std::string_view> five = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  static const std::vector<std::string_view> eight = {"fx", "fy", "cx", "cy", "k1", "k2",
                                                      "p1", "p2", "k3", "k4", "k5", "k6"};
  static const std::vector<std::string_view> fisheye = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};
  switch (model) {
    case LensModel::pinhole_5:
      return five;
    case LensModel::pinhole_8:
      return eight;
    case LensModel::equidistant:
      return fisheye;
    case LensModel::pinhole_4:
      break;
  }
  return four;
}

std::optional<Lens::Projection> Lens::project(const Eigen::Vector3d& point_in_camera) const {
  return with_model(model,
                    [&]<LensModel kind>() { return project_with_derivatives<kind>(parameters, point_in_camera); });
}

std::optional<Eigen::Vector3d> Lens::unproject(const Eigen::Vector2d& pixel) const {
  const auto ray = camera_of(*this, 0, 0).unproject(pixel);
  if (!ray) return std::nullopt;
  return Eigen::Vector3d(ray->x(), ray->y(), 1.0).normalized();
}

Lens undistorted_lens(LensModel model, double focal_length, const Eigen::Vector2d& center) {
  Lens lens{model, Eigen::VectorXd::Zero(lens_size(model))};
  lens.parameters.head<4>() << focal_length, focal_length, center.x(), center.y();
  return lens;
}

Lens as_model(const Lens& lens, LensModel model) {
  Lens result{model, Eigen::VectorXd::Zero(lens_size(model))};
  const bool same_kind = (lens.model == LensModel::equidistant) == (model == LensModel::equidistant);
  const Eigen::Index kept = same_kind ? std::min(lens.parameters.size(), result.parameters.size()) : Eigen::Index{4};
  result.parameters.head(kept) = lens.parameters.head(kept);
  return result;
}

Camera camera_of(const Lens& lens, int width, int height) {
  const Eigen::VectorXd& p = lens.parameters;
  Camera camera{width, height, p[0], p[1], p[2], p[3]};
  camera.distortion = lens.model == LensModel::equidistant ? Distortion::equidistant
                      : lens.model == LensModel::pinhole_8 ? Distortion::rational
                                                           : Distortion::radial_tangential;
  for (Eigen::Index i = 4; i < p.size(); ++i) camera.coefficients[static_cast<std::size_t>(i - 4)] = p[i];
  return camera;
}

}  // namespace rastro
