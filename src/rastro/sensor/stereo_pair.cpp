// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/stereo_pair.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"

namespace rastro {
namespace {

/// Whether corresponding points are in the same row of both images: pinhole cameras of one kind, side by side.
bool is_rectified(const SourceInfo& source) {
  if (source.cameras.size() < 2 || !source.cameras[1].camera || !source.left_from_right) return false;
  const Camera &left = *source.cameras[0].camera, &right = *source.cameras[1].camera;
  constexpr double most_px = 0.5, most_rad = 0.001, most_share = 0.005;
  const Eigen::Vector3d aside = source.left_from_right->translation();
  return left.distortion == Distortion::none && right.distortion == Distortion::none &&
         std::abs(left.fx - right.fx) < most_px && std::abs(left.fy - right.fy) < most_px &&
         std::abs(left.cx - right.cx) < most_px && std::abs(left.cy - right.cy) < most_px &&
         source.left_from_right->rotation().log().norm() < most_rad && aside.x() > 0.0 &&
         std::hypot(aside.y(), aside.z()) < most_share * aside.x();
}

}  // namespace

SE3 StereoPair::camera_from_left() const {
  return rectification ? SE3(rectification->left_from_rectified.inverse(), Eigen::Vector3d::Zero()) : SE3();
}

bool has_calibrated_pair(const SourceInfo& source) {
  return source.cameras.size() > 1 && source.cameras[0].camera && source.cameras[1].camera && source.left_from_right;
}

std::optional<StereoPair> stereo_pair(const SourceInfo& source) {
  if (!has_calibrated_pair(source)) return std::nullopt;
  const Camera &left = *source.cameras[0].camera, &right = *source.cameras[1].camera;
  if (is_rectified(source)) return StereoPair{left, source.left_from_right->translation().x(), nullptr};
  auto made = rectify_stereo(left, right, *source.left_from_right);
  if (!made) return std::nullopt;
  const auto rectification = std::make_shared<const StereoRectification>(std::move(*made));
  return StereoPair{rectification->camera, rectification->baseline, rectification};
}

std::optional<StereoPair> choose_stereo_pair(const SourceInfo& source, bool is_required) {
  auto pair = stereo_pair(source);
  if (pair) return pair;
  const char* why =
      has_calibrated_pair(source)
          ? "has stereo images of cameras that are not side by side, or whose sizes are not in the calibration"
          : "has stereo images without calibration of both cameras and their baseline";
  if (is_required) throw Error(why, source.path, "give --calibration FILE, or --sensor mono");
  log_warning(source.path + " " + why + ": only the left camera is used");
  return std::nullopt;
}

FrameRectifier::FrameRectifier(std::shared_ptr<const StereoRectification> rectification, TaskPool* pool)
    : rectification_(std::move(rectification)), pool_(pool) {
  constexpr int margin = 16;  // Corners at the border of the valid area are artifacts; the coarsest level reaches this
                              // far.
  const Camera& camera = rectification_->camera;  // of the recorded size
  shown_ = shown_by(rectification_->left, camera.width, camera.height, margin);
}

Frame FrameRectifier::rectified(const Frame& frame) const {
  const auto is_of_camera = [&](GrayView image) {
    return image.width == rectification_->camera.width && image.height == rectification_->camera.height;
  };
  if (!is_of_camera(frame.image.view()) || !(frame.right.empty() || is_of_camera(frame.right.view())))
    throw Error("has another size than the calibration", "frame " + std::to_string(frame.index),
                "give the calibration of these images");
  Frame made;
  made.index = frame.index;
  made.stamp = frame.stamp;
  made.name = frame.name;
  made.image = remap(frame.image.view(), rectification_->left, pool_);
  if (!frame.right.empty()) made.right = remap(frame.right.view(), rectification_->right, pool_);
  made.mask = shown_;
  if (frame.mask.empty()) return made;
  const GrayImage mask = remap(frame.mask.view(), rectification_->left, pool_);
  constexpr std::uint8_t half = 128;  // The border of a mask has interpolated values.
  for (int y = 0; y < mask.height(); ++y)
    std::transform(mask.row(y), mask.row(y) + mask.width(), made.mask.row(y), made.mask.row(y),
                   [](std::uint8_t a, std::uint8_t b) { return a < half ? std::uint8_t{0} : b; });
  return made;
}

}  // namespace rastro
