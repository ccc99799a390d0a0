// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/dataset/open.h"

namespace rastro {

/// Whether the file begins as a ROS 1 bag does, or has its ending.
bool is_rosbag(const std::string& path);

/// A ROS 1 bag, its messages decoded by ROS' own serialization. One topic drives the frames: the first (by name) of
/// sensor_msgs/LaserScan; where there is none, the first of Image with brightness or color, then of CompressedImage;
/// options.camera names another image topic. With a frame come the last nav_msgs/Odometry before it (its x, y and
/// heading), the sensor_msgs/Imu since the frame before, and for images the depth whose header is nearest in time (at
/// most 20 ms), recorded up to half a second before or after the image; of each the topic that comes first by name, of
/// depth those called registered or aligned first, then Image before compressedDepth (PNG), of CameraInfo the one
/// beside the image. Warnings say what was chosen among several. Stamps are those of the headers; of the recording
/// where a header has none. The laser is taken to stand at the body's origin (tf is not read). A bag that was cut short
/// or never closed is read as far as it is whole, with a warning. Error where it is not a bag or holds none of these,
/// and always in a build without ROS bags.
std::unique_ptr<Source> open_rosbag(const std::string& path, const OpenOptions& options);

}  // namespace rastro
