// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/method_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "rastro/base/error.h"
#include "rastro/feature/orb.h"
#include "rastro/sensor/stereo_pair.h"

namespace rastro {
namespace {

constexpr int columns = 8, rows = 6;

bool has_calibrated_camera(const SourceInfo& source) {
  return source.has_image && !source.cameras.empty() && source.cameras.front().camera;
}

const char* by_keyframes(bool live) { return live ? "orb" : "fusion"; }

std::vector<MethodChoice> with_depth(double texture, double least_texture, bool live) {
  const std::string seen = fmt::format("a depth camera, corners in {:.0f} % of the image", 100.0 * texture);
  const MethodChoice everything{by_keyframes(live), seen}, surfaces{"rgbd", seen + ": surfaces help"};
  if (texture >= least_texture) return {everything, surfaces};
  return {surfaces, everything};
}

}  // namespace

double texture_of(GrayView image, int threshold) {
  if (image.width < 8 * columns || image.height < 8 * rows) return 0.0;
  const OrbOptions options{.levels = 1, .fast_threshold = threshold, .least_fast_threshold = threshold};
  std::array<bool, columns * rows> has_corner{};
  for (const Keypoint& corner : OrbExtractor(options).extract(image).keypoints) {
    const int x = static_cast<int>(corner.x) * columns / image.width;
    const int y = static_cast<int>(corner.y) * rows / image.height;
    has_corner[static_cast<std::size_t>(y * columns + x)] = true;
  }
  return static_cast<double>(std::count(has_corner.begin(), has_corner.end(), true)) / (columns * rows);
}

std::vector<MethodChoice> slam_choices(const SourceInfo& source, double texture, double least_texture, bool live) {
  if (source.has_scan) return {{"hector", "laser scans"}};
  if (has_calibrated_camera(source)) {
    if (source.has_depth) return with_depth(texture, least_texture, live);
    if (source.has_right && stereo_pair(source)) return {{by_keyframes(live), "a stereo pair"}};
    if (source.has_right) return {{"orb", "two cameras that are no calibrated pair: the left one alone"}};
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
