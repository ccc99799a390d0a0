// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/method_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/feature/fast.h"
#include "rastro/image/padded_image.h"

namespace rastro {
namespace {

constexpr int columns = 8, rows = 6;

PaddedImage padded(GrayView image) {
  PaddedImage copy;
  copy.reset(image.width, image.height, fast_padding);
  for (int y = 0; y < image.height; ++y) std::copy_n(image.row(y), image.width, copy.row(y));
  copy.fill_padding();
  return copy;
}

bool has_calibrated_camera(const SourceInfo& source) {
  return source.has_image && !source.cameras.empty() && source.cameras.front().camera;
}

std::vector<MethodChoice> with_depth(double texture, double least_texture) {
  const std::string seen = fmt::format("a depth camera, corners in {:.0f} % of the image", 100.0 * texture);
  const MethodChoice keyframes{"orb", seen}, surfaces{"rgbd", seen + ": surfaces help"};
  if (texture >= least_texture) return {keyframes, surfaces};
  return {surfaces, keyframes};
}

}  // namespace

double texture_of(GrayView image, int threshold) {
  if (image.width < 8 * columns || image.height < 8 * rows) return 0.0;
  const PaddedImage copy = padded(image);
  int with_corner = 0;
  std::vector<FastCorner> corners;
  for (int cell = 0; cell < columns * rows; ++cell) {
    const int x = cell % columns, y = cell / columns;
    corners.clear();
    fast_corners(copy, image.width * x / columns, image.width * (x + 1) / columns, image.height * y / rows,
                 image.height * (y + 1) / rows, threshold, corners);
    with_corner += corners.empty() ? 0 : 1;
  }
  return static_cast<double>(with_corner) / (columns * rows);
}

std::vector<MethodChoice> slam_choices(const SourceInfo& source, double texture, double least_texture) {
  if (source.has_scan) return {{"hector", "laser scans"}};
  if (has_calibrated_camera(source)) {
    if (source.has_depth) return with_depth(texture, least_texture);
    if (source.has_right) return {{"orb", "a stereo pair"}};
    return {{"orb", "one camera: the map is up to scale"}};
  }
  if (source.has_landmarks && source.has_odometry) return {{"ekf", "landmark observations and wheel odometry"}};
  if (source.has_image) throw Error("has no calibration", source.path, "give one with --calibration FILE");
  throw Error("has nothing that a SLAM method can use", source.path, "'rastro methods' says what each needs");
}

MethodChoice odometry_choice(const SourceInfo& source) {
  if (!source.has_image) throw Error("has no images", source.path, "an odometry needs a recording of a camera");
  if (!has_calibrated_camera(source))
    throw Error("has no calibration", source.path, "give one with --calibration FILE");
  if (source.has_depth) return {"rgbd", "a depth camera"};
  return {"features", "one camera"};
}

}  // namespace rastro
