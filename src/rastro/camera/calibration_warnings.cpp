// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/camera/camera.h"
#include "rastro/camera/distortion.h"

namespace rastro {
namespace {

constexpr double smallest_field_of_view_deg = 10.0;
constexpr double largest_field_of_view_deg = 150.0;
constexpr double largest_focal_length_ratio = 1.05;
constexpr double least_pincushion = 0.75, largest_tangential = 0.05;
constexpr double farthest_principal_point = 0.2;  // Share of the image's size, from its center.

void check_field_of_view(const Camera& camera, std::vector<std::string>& warnings) {
  // An equidistant lens images an angle a at f * a, so that wide angles are its normal use.
  if (camera.distortion == Distortion::equidistant) return;
  const double degrees = 2.0 * std::atan(0.5 * camera.width / camera.fx) * 180.0 / std::numbers::pi;
  if (degrees >= smallest_field_of_view_deg && degrees <= largest_field_of_view_deg) return;
  warnings.push_back(fmt::format(
      "focal length fx = {:.6g} px in an image {} px wide means a horizontal field of view of {:.3g} degrees "
      "(expected {:g} to {:g}): are the intrinsics of another image size?",
      camera.fx, camera.width, degrees, smallest_field_of_view_deg, largest_field_of_view_deg));
}

void check_focal_lengths(const Camera& camera, std::vector<std::string>& warnings) {
  const double ratio = std::max(camera.fx, camera.fy) / std::min(camera.fx, camera.fy);
  if (ratio <= largest_focal_length_ratio) return;
  warnings.push_back(
      fmt::format("fx = {:.6g} and fy = {:.6g} differ by {:.3g} %, and pixels are square in most cameras: "
                  "is a value wrong, or the image stretched?",
                  camera.fx, camera.fy, 100.0 * (ratio - 1.0)));
}

void check_principal_point(const Camera& camera, std::vector<std::string>& warnings) {
  const double off_x = std::abs(camera.cx - 0.5 * (camera.width - 1)) / camera.width;
  const double off_y = std::abs(camera.cy - 0.5 * (camera.height - 1)) / camera.height;
  if (off_x > 0.5 || off_y > 0.5) {
    warnings.push_back(
        fmt::format("principal point ({:.6g}, {:.6g}) lies outside the {}x{} image: are the intrinsics of "
                    "another image size, or cx and cy swapped?",
                    camera.cx, camera.cy, camera.width, camera.height));
  } else if (std::max(off_x, off_y) > farthest_principal_point) {
    warnings.push_back(
        fmt::format("principal point ({:.6g}, {:.6g}) is {:.0f} % of the size away from the center of the "
                    "{}x{} image: is the image cropped, or of another size?",
                    camera.cx, camera.cy, 100.0 * std::max(off_x, off_y), camera.width, camera.height));
  }
}

/// What no lens does: rows and columns bent outward by much, or a sensor tilted by much.
void check_distortion_size(const Camera& camera, std::vector<std::string>& warnings) {
  if (camera.distortion == Distortion::equidistant) return;
  double narrowest = 1.0;
  for (const double x : {0.0, camera.width - 1.0})
    for (const double y : {0.0, camera.height - 1.0}) {
      const Eigen::Vector2d distorted((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
      if (const auto ray = camera.unproject({x, y})) narrowest = std::min(narrowest, ray->norm() / distorted.norm());
    }
  const double tangential = std::max(std::abs(camera.coefficients[2]), std::abs(camera.coefficients[3]));
  std::string what;
  if (narrowest < least_pincushion)
    what = fmt::format("it moves a corner outward to {:.2g} times its distance", 1.0 / narrowest);
  if (tangential > largest_tangential)
    what += fmt::format("{}tangential coefficients up to {:.2g}", what.empty() ? "" : ", ", tangential);
  if (what.empty()) return;
  warnings.push_back(fmt::format(
      "the distortion is larger than that of a lens ({}): are the coefficients in the right order, and of this model?",
      what));
}

void check_distortion(const Camera& camera, std::vector<std::string>& warnings) {
  if (camera.distortion == Distortion::none) return;
  int lost = 0;
  for (const double x : {0.0, camera.width - 1.0})
    for (const double y : {0.0, camera.height - 1.0}) lost += camera.unproject({x, y}) ? 0 : 1;
  if (lost == 0) {
    check_distortion_size(camera, warnings);
    return;
  }
  warnings.push_back(
      fmt::format("the distortion folds back inside the image ({} of 4 corners have no ray; the model grows "
                  "only up to a radius of {:.3g} focal lengths): are the coefficients in the right order, "
                  "and of this model?",
                  lost, monotonic_radius(camera)));
}

}  // namespace

std::vector<std::string> calibration_warnings(const Camera& camera) {
  std::vector<std::string> warnings;
  if (!(camera.fx > 0.0 && camera.fy > 0.0)) {
    warnings.push_back(fmt::format("focal lengths fx = {:.6g}, fy = {:.6g} must be positive", camera.fx, camera.fy));
    return warnings;
  }
  check_focal_lengths(camera, warnings);
  if (camera.width <= 0 || camera.height <= 0) return warnings;
  check_field_of_view(camera, warnings);
  check_principal_point(camera, warnings);
  check_distortion(camera, warnings);
  return warnings;
}

}  // namespace rastro
