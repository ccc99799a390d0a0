// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/so3.h"

namespace rastro {

/// For each pixel of an undistorted image, its position in the recorded one.
struct UndistortMap {
  Camera camera;   ///< Pinhole without distortion: the camera of the undistorted image.
  Image<float> x;  ///< Pixels in the recorded image; NaN where the lens does not image the ray.
  Image<float> y;
};

/// The pinhole camera of an undistorted image of the same size. `alpha` 0: every pixel of it is inside the recorded
/// image; 1: every pixel of the recorded image is shown; values in between interpolate. A recorded pixel without a ray,
/// or at more than about 80 degrees from the axis, does not count. `camera` must have a size and positive focal
/// lengths.
Camera undistorted_camera(const Camera& camera, double alpha);

/// `camera_from_undistorted`: orientation of an undistorted camera that looks in another direction, as in a rectified
/// pair.
UndistortMap undistort_map(const Camera& camera, const Camera& undistorted, const SO3& camera_from_undistorted = {});
inline UndistortMap undistort_map(const Camera& camera, double alpha) {
  return undistort_map(camera, undistorted_camera(camera, alpha));
}

/// The undistorted image, bilinear with rounding to nearest; 0 where the map points outside `recorded`. The same bytes
/// for any pool.
GrayImage remap(GrayView recorded, const UndistortMap& map, TaskPool* pool = nullptr);

/// Mask of the undistorted image for a recorded image of this size: 0 where there is no image, and in `margin` rows and
/// columns around that; else 255.
GrayImage shown_by(const UndistortMap& map, int recorded_width, int recorded_height, int margin);

}  // namespace rastro
