// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/sensor/laser_scan.h"

namespace rastro {

struct ScanFromDepthOptions {
  /// Band of heights above the optical center, meters, upward along the image's columns: what lies outside is not seen.
  double lowest = -0.05, highest = 0.05;
  double min_range = 0.1;   ///< Meters; a nearer point is not seen.
  double max_range = 10.0;  ///< Meters; a farther one means that nothing stands within reach.
};

/// Cuts a scan out of depth images, as ROS' depthimage_to_laserscan does: of all points in the band of heights, the
/// nearest in each direction. The laser frame stands in the optical center, x along the optical axis; the beams are as
/// far apart as pixels are in the middle of the image, so that each has a pixel. A beam without a point is broken: 0.
class ScanFromDepth {
 public:
  /// Error where the camera is no use for it (no focal length or size), or the options are out of range.
  ScanFromDepth(const Camera& camera, const ScanFromDepthOptions& options);

  /// The image must have the camera's size (a promise).
  LaserScan cut(const DepthImage& depth) const;

 private:
  struct Ray {
    float right = 0.0F, down = 0.0F;  ///< Meters in one meter of depth; nan where the lens gives none.
    int beam = 0;
  };
  int width_, height_;
  ScanFromDepthOptions options_;
  double first_angle_ = 0.0, angle_step_ = 0.0;
  int beams_ = 0;
  std::vector<Ray> rays_;  ///< Of each pixel, row by row.
};

}  // namespace rastro
