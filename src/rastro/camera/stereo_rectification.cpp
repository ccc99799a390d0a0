// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/stereo_rectification.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace rastro {
namespace {

constexpr int parts = 128;  // Of a pixel.
constexpr int rows_at_a_time = 16;
constexpr double most_aside_rad = 30.0 * std::numbers::pi / 180.0, most_apart_rad = 40.0 * std::numbers::pi / 180.0;

/// Where the camera sees what the turned one sees in a pixel.
std::optional<Eigen::Vector2d> pixel_of(const Camera& source, const Camera& target, const Eigen::Matrix3d& turn, int x,
                                        int y) {
  const Eigen::Vector3d ray((x - target.cx) / target.fx, (y - target.cy) / target.fy, 1.0);
  const auto pixel = source.project(turn * ray);
  // A lens model may fold back far outside of the picture: what it undistorts to is somewhere else then.
  if (!pixel) return std::nullopt;
  const auto back = source.unproject(*pixel);
  const Eigen::Vector3d turned = turn * ray;
  if (!back || (*back - turned.head<2>() / turned.z()).norm() > 1e-3) return std::nullopt;
  return pixel;
}

/// Zero where a zero lies within `margin` rows or columns.
void shrink(GreyImage& mask, int margin) {
  const GreyImage before = mask;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (before.at(x, y) != 0) continue;
      // Only an edge reaches farther than itself.
      const bool edge = (x > 0 && before.at(x - 1, y) != 0) || (x + 1 < mask.width() && before.at(x + 1, y) != 0) ||
                        (y > 0 && before.at(x, y - 1) != 0) || (y + 1 < mask.height() && before.at(x, y + 1) != 0);
      if (!edge) continue;
      const int left = std::max(0, x - margin), right = std::min(mask.width(), x + margin + 1);
      for (int row = std::max(0, y - margin); row < std::min(mask.height(), y + margin + 1); ++row)
        std::fill(mask.row(row) + left, mask.row(row) + right, std::uint8_t{0});
    }
  }
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Of the rectified cameras in the left one.
SO3 axes_of(const SE3& left_from_right) {
  const Eigen::Vector3d x = left_from_right.translation().normalized();
  const Eigen::Vector3d forward =
      Eigen::Vector3d::UnitZ() + left_from_right.rotation().matrix() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = forward.cross(x).normalized();
  Eigen::Matrix3d axes;
  axes << x, y, x.cross(y);
  return SO3::from_matrix(axes);
}

/// Without distortion; the middles of both pictures lie as near to its middle as they can.
Camera camera_for(const Camera& left, const Camera& right, const SO3& left_from_rectified,
                  const SO3& right_from_rectified) {
  Camera camera;
  camera.width = left.width;
  camera.height = left.height;
  camera.fx = camera.fy = 0.25 * (left.fx + left.fy + right.fx + right.fy);
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& [from, turn] : {std::pair{&left, &left_from_rectified}, std::pair{&right, &right_from_rectified}}) {
    const Eigen::Vector2d centre(0.5 * (from->width - 1), 0.5 * (from->height - 1));
    const Eigen::Vector2d ray = from->unproject(centre).value_or(Eigen::Vector2d::Zero());
    const Eigen::Vector3d turned = turn->inverse() * Eigen::Vector3d(ray.x(), ray.y(), 1.0);
    middle += 0.5 * turned.head<2>() / turned.z();
  }
  camera.cx = 0.5 * (camera.width - 1) - camera.fx * middle.x();
  camera.cy = 0.5 * (camera.height - 1) - camera.fy * middle.y();
  return camera;
}

}  // namespace

PictureWarp::PictureWarp(const Camera& source, const Camera& target, const SO3& source_from_target)
    : source_width_(source.width), source_height_(source.height), width_(target.width), height_(target.height) {
  RASTRO_CHECK(source.width > 1 && source.height > 1 && target.width > 0 && target.height > 0, "sizes are known");
  const Eigen::Matrix3d turn = source_from_target.matrix();
  taps_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const auto pixel = pixel_of(source, target, turn, x, y);
      if (!pixel || !(pixel->x() >= 0.0 && pixel->y() >= 0.0)) continue;
      if (!(pixel->x() <= source.width - 1.0 && pixel->y() <= source.height - 1.0)) continue;
      const int u = std::min(static_cast<int>(pixel->x()), source.width - 2);
      const int v = std::min(static_cast<int>(pixel->y()), source.height - 2);
      taps_[static_cast<std::size_t>(y * width_ + x)] = {
          static_cast<std::int16_t>(u), static_cast<std::int16_t>(v),
          static_cast<std::uint8_t>(std::lround(parts * (pixel->x() - u))),
          static_cast<std::uint8_t>(std::lround(parts * (pixel->y() - v)))};
    }
  }
}

GreyImage PictureWarp::warp(GreyView image, TaskPool* pool) const {
  RASTRO_CHECK(image.width == source_width_ && image.height == source_height_, "a picture of the camera");
  GreyImage made(width_, height_);
  const auto rows = [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      const Tap* tap = taps_.data() + static_cast<std::ptrdiff_t>(y) * width_;
      std::uint8_t* to = made.row(y);
      for (int x = 0; x < width_; ++x, ++tap) {
        if (tap->x < 0) continue;
        const std::uint8_t* from = image.row(tap->y) + tap->x;
        const std::uint8_t* next = from + image.stride;
        const int upper = from[0] * (parts - tap->right) + from[1] * tap->right;
        const int lower = next[0] * (parts - tap->right) + next[1] * tap->right;
        constexpr int half = parts * parts / 2;
        to[x] = static_cast<std::uint8_t>((upper * (parts - tap->below) + lower * tap->below + half) / (parts * parts));
      }
    }
  };
  pool ? pool->for_chunks(0, height_, rows_at_a_time, rows) : rows(0, height_);
  return made;
}

GreyImage PictureWarp::warp_mask(GreyView mask, int margin) const {
  RASTRO_CHECK(mask.empty() || (mask.width == source_width_ && mask.height == source_height_), "a mask of the camera");
  GreyImage made(width_, height_);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) made.at(x, y) = taps_[static_cast<std::size_t>(y * width_ + x)].x < 0 ? 0 : 255;
  }
  shrink(made, margin);
  if (mask.empty()) return made;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Tap& tap = taps_[static_cast<std::size_t>(y * width_ + x)];
      if (tap.x >= 0 && mask.at(tap.x + (tap.right > parts / 2), tap.y + (tap.below > parts / 2)) == 0)
        made.at(x, y) = 0;
    }
  }
  return made;
}

std::optional<StereoRectification> rectify_stereo(const Camera& left, const Camera& right, const SE3& left_from_right) {
  constexpr int largest_side = 32767;
  if (left.width < 2 || left.height < 2 || left.width != right.width || left.height != right.height) return {};
  if (left.width > largest_side || left.height > largest_side) return {};
  const Eigen::Vector3d aside = left_from_right.translation();
  const Eigen::Vector3d right_view = left_from_right.rotation().matrix() * Eigen::Vector3d::UnitZ();
  if (!(aside.norm() > 0.0) || angle_between(aside, Eigen::Vector3d::UnitX()) > most_aside_rad) return {};
  if (angle_between(right_view, Eigen::Vector3d::UnitZ()) > most_apart_rad) return {};
  const SO3 left_from_rectified = axes_of(left_from_right);
  const SO3 right_from_rectified = left_from_right.rotation().inverse() * left_from_rectified;
  const Camera camera = camera_for(left, right, left_from_rectified, right_from_rectified);
  return StereoRectification{camera, aside.norm(), left_from_rectified, PictureWarp(left, camera, left_from_rectified),
                             PictureWarp(right, camera, right_from_rectified)};
}

}  // namespace rastro
