// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/camera/file/formats.h"
#include "rastro/camera/file/yaml_fields.h"

namespace rastro::calibration {
namespace {

constexpr int largest_size = 100000;
constexpr double largest_focal_length = 1e7;
constexpr double largest_coefficient = 1e6;

enum class Model { none, radial_tangential, equidistant, rational };

struct NamedModel {
  std::string_view name;
  Model model;
};

constexpr NamedModel models[] = {{"none", Model::none},
                                 {"radial-tangential", Model::radial_tangential},
                                 {"radial_tangential", Model::radial_tangential},
                                 {"radtan", Model::radial_tangential},
                                 {"plumb_bob", Model::radial_tangential},
                                 {"equidistant", Model::equidistant},
                                 {"equi", Model::equidistant},
                                 {"fisheye", Model::equidistant},
                                 {"rational_polynomial", Model::rational}};

Model model_of(std::string_view name, const std::string& where) {
  std::vector<std::string> names;
  for (const auto& known : models) {
    if (known.name == name) return known.model;
    names.emplace_back(known.name);
  }
  throw Error(
      fmt::format("distortion model '{}' is not supported", one_line(name, 40)), where,
      did_you_mean(name, names,
                   "known are none, radial-tangential (radtan, plumb_bob), rational_polynomial and equidistant"));
}

bool all_zero(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return value == 0.0; });
}

/// Without the zeros behind the first `count`, which some writers pad to a fixed length with.
std::span<const double> without_padding(std::span<const double> values, std::size_t count) {
  return values.size() > count && all_zero(values.subspan(count)) ? values.first(count) : values;
}

void require_count(std::span<const double> values, std::initializer_list<std::size_t> counts, std::string_view model,
                   const std::string& where, std::string_view key) {
  if (std::find(counts.begin(), counts.end(), values.size()) != counts.end()) return;
  throw Error(fmt::format("{} has {} values, which does not fit the model '{}'", key, values.size(), model), where,
              fmt::format("it needs {}", fmt::join(counts, " or ")));
}

}  // namespace

void set_distortion(Camera& camera, std::string_view model, std::span<const double> coefficients,
                    const std::string& where, std::string_view key) {
  const Model kind = model_of(model, where);
  for (const double value : coefficients)
    if (!(std::abs(value) <= largest_coefficient))
      throw Error(fmt::format("{} holds {:g}, which is not a plausible distortion coefficient", key, value), where, "");
  camera.distortion = Distortion::none;
  camera.coefficients = {};
  if (kind == Model::none || kind == Model::rational) {
    // OpenCV's order: k1 k2 p1 p2 k3, then k4 k5 k6 of the denominator, then thin prism and tilt.
    const std::size_t understood = kind == Model::none ? 0 : std::min<std::size_t>(coefficients.size(), 8);
    if (!all_zero(coefficients.subspan(understood)))
      throw Error(fmt::format("{} of the model '{}' has values beyond {} that are not zero", key, model, understood),
                  where, "calibrate with the radial-tangential (plumb_bob), the rational or the equidistant model");
    coefficients = coefficients.first(understood);
  } else if (kind == Model::equidistant) {
    coefficients = without_padding(coefficients, 4);
    require_count(coefficients, {4}, model, where, key);
    camera.distortion = Distortion::equidistant;
  } else {
    coefficients = without_padding(coefficients, 5);
    require_count(coefficients, {0, 4, 5}, model, where, key);
  }
  std::copy(coefficients.begin(), coefficients.end(), camera.coefficients.begin());
  // All zero means no distortion, which is cheaper; an equidistant lens bends rays even then.
  if (kind == Model::equidistant || all_zero(coefficients)) return;
  const bool divided = coefficients.size() > 5 && !all_zero(coefficients.subspan(5));
  camera.distortion = divided ? Distortion::rational : Distortion::radial_tangential;
}

void set_size(Camera& camera, double width, double height, const std::string& where) {
  for (const double value : {width, height})
    if (!(value >= 1.0 && value <= largest_size && value == std::floor(value)))
      throw Error(fmt::format("image size {:g}x{:g} is not possible", width, height), where,
                  fmt::format("it must be 1 to {} pixels in width and height", largest_size));
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
}

void set_intrinsics(Camera& camera, const YamlFields& fields) {
  const auto values = fields.numbers({"intrinsics"}, 4);
  camera.fx = values[0];
  camera.fy = values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  require_usable(camera, fields.at({"intrinsics"}));
}

std::optional<double> optional_rate(const YamlFields& fields) {
  if (!fields.has({"rate_hz"})) return std::nullopt;
  const double rate = fields.number({"rate_hz"});
  if (!(rate > 0.0)) fields.fail({"rate_hz"}, "is not positive", "");
  return rate;
}

std::optional<double> optional_calibration_error(const YamlFields& fields) {
  static constexpr Names key = {"calibration_error"};
  if (!fields.has(key)) return std::nullopt;
  const double error = fields.number(key);
  if (!(error >= 0.0 && error <= 1.0)) fields.fail(key, "is not a share", "0.005 says half a percent");
  return error;
}

void set_readout_time(Camera& camera, const YamlFields& fields) {
  static constexpr Names key = {"readout_time"};
  if (!fields.has(key)) return;
  camera.readout_s = fields.number(key);
  if (!(camera.readout_s >= 0.0 && camera.readout_s <= 1.0))
    fields.fail(key, "is no readout time", "it is given in seconds, from 0 to 1");
}

void require_usable(const Camera& camera, const std::string& where) {
  for (const double focal_length : {camera.fx, camera.fy})
    if (!(focal_length > 0.0 && focal_length < largest_focal_length))
      throw Error(fmt::format("focal length {:g} px is not possible", focal_length), where,
                  "it is positive and given in pixels");
  for (const double center : {camera.cx, camera.cy})
    if (!(std::abs(center) < largest_focal_length))
      throw Error(fmt::format("principal point at {:g} px is not possible", center), where, "it is given in pixels");
}

SE3 rigid_transform(const Eigen::MatrixXd& matrix, std::string_view key, const std::string& where,
                    std::vector<std::string>& warnings) {
  Eigen::Matrix4d full = Eigen::Matrix4d::Identity();
  full.topRows(matrix.rows()) = matrix;
  const Eigen::Matrix3d rotation = full.topLeftCorner<3, 3>();
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const bool last_row = full.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (!(error < 0.1) || !last_row || !(rotation.determinant() > 0.0))
    throw Error(fmt::format("{} is not a rigid transform (rotation and translation)", key), where,
                "its first three columns are at right angles and of length 1");
  if (error > 2e-3)
    warnings.push_back(fmt::format("{} is not quite a rotation (error {:.2g}); the nearest one is used", key, error));
  return SE3::from_matrix(full);
}

void check_baseline(const SE3& second_from_first, std::string_view first, std::string_view second,
                    std::vector<std::string>& warnings) {
  const Eigen::Vector3d at = second_from_first.inverse().translation();
  const bool parallel = second_from_first.rotation().log().norm() < 0.3;
  if (!parallel || at.x() >= 0.0 || -at.x() < 0.7 * at.norm()) return;
  warnings.push_back(
      fmt::format("{} is {:.3g} m to the LEFT of {}, by the sign of its baseline: are the two swapped, or the "
                  "transform inverted?",
                  second, -at.x(), first));
}

}  // namespace rastro::calibration
