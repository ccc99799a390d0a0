// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/stereo_rectification.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

namespace rastro {
namespace {

constexpr double most_aside_rad = 30.0 * std::numbers::pi / 180.0, most_apart_rad = 40.0 * std::numbers::pi / 180.0;

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Orientation of the rectified cameras in the left one.
SO3 axes_of(const SE3& left_from_right) {
  const Eigen::Vector3d x = left_from_right.translation().normalized();
  const Eigen::Vector3d forward =
      Eigen::Vector3d::UnitZ() + left_from_right.rotation().matrix() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = forward.cross(x).normalized();
  Eigen::Matrix3d axes;
  axes << x, y, x.cross(y);
  return SO3::from_matrix(axes);
}

/// Without distortion; the centers of both images are as close to its center as possible.
Camera camera_for(const Camera& left, const Camera& right, const SO3& left_from_rectified,
                  const SO3& right_from_rectified) {
  Camera camera;
  camera.width = left.width;
  camera.height = left.height;
  camera.fx = camera.fy = 0.25 * (left.fx + left.fy + right.fx + right.fy);
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& [from, camera_from_rectified] :
       {std::pair{&left, &left_from_rectified}, std::pair{&right, &right_from_rectified}}) {
    const Eigen::Vector2d center(0.5 * (from->width - 1), 0.5 * (from->height - 1));
    const Eigen::Vector2d ray = from->unproject(center).value_or(Eigen::Vector2d::Zero());
    const Eigen::Vector3d rectified = camera_from_rectified->inverse() * Eigen::Vector3d(ray.x(), ray.y(), 1.0);
    middle += 0.5 * rectified.head<2>() / rectified.z();
  }
  camera.cx = 0.5 * (camera.width - 1) - camera.fx * middle.x();
  camera.cy = 0.5 * (camera.height - 1) - camera.fy * middle.y();
  return camera;
}

}  // namespace

std::optional<StereoRectification> rectify_stereo(const Camera& left, const Camera& right, const SE3& left_from_right) {
  if (left.width < 2 || left.height < 2 || left.width != right.width || left.height != right.height) return {};
  const Eigen::Vector3d& aside = left_from_right.translation();
  const Eigen::Vector3d right_view = left_from_right.rotation().matrix() * Eigen::Vector3d::UnitZ();
  if (!(aside.norm() > 0.0) || angle_between(aside, Eigen::Vector3d::UnitX()) > most_aside_rad) return {};
  if (angle_between(right_view, Eigen::Vector3d::UnitZ()) > most_apart_rad) return {};
  const SO3 left_from_rectified = axes_of(left_from_right);
  const SO3 right_from_rectified = left_from_right.rotation().inverse() * left_from_rectified;
  const Camera camera = camera_for(left, right, left_from_rectified, right_from_rectified);
  return StereoRectification{camera, aside.norm(), left_from_rectified,
                             undistort_map(left, camera, left_from_rectified),
                             undistort_map(right, camera, right_from_rectified)};
}

}  // namespace rastro
