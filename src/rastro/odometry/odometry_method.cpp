// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/odometry_method.h"

#include "rastro/base/error.h"

namespace rastro {

const Camera& calibrated_camera(const SourceInfo& source) {
  if (!source.has_image)
    throw Error("has no images, and odometry needs them", source.path, "'rastro slam' reads laser scans");
  if (source.cameras.empty() || !source.cameras.front().camera)
    throw Error("has no calibration, and poses need one", source.path,
                "give --calibration FILE, --intrinsics fx,fy,cx,cy or --fov DEG");
  return *source.cameras.front().camera;
}

}  // namespace rastro
