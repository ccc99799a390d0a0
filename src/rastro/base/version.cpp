// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/version.h"

#include "rastro_version.h"  // made by CMake from cmake/version.h.in

namespace rastro {

const Version& version() {
  static const Version instance = {RASTRO_VERSION_NUMBER,
                                   RASTRO_VERSION_COMMIT,
                                   RASTRO_VERSION_COMPILER,
                                   {{"video files", RASTRO_VERSION_WITH_VIDEO != 0},
                                    {"SURF", RASTRO_VERSION_WITH_SURF != 0},
                                    {"ROS bags", RASTRO_VERSION_WITH_ROSBAG != 0}}};
  return instance;
}

}  // namespace rastro
