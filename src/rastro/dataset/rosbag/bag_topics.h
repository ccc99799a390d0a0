// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>
#include <string>

#include "rastro/dataset/image_file.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/rosbag/bag_contents.h"

namespace rastro {

/// The topics of a bag that are read; empty where there is none.
struct BagTopics {
  std::string scan, image, compressed, depth, camera_info, odometry, imu;

  const std::string& main() const { return !scan.empty() ? scan : !image.empty() ? image : compressed; }
};

/// By the rules of open_rosbag(), with a warning in `info` wherever others were left. Error where there is nothing to
/// read, or no image topic that options.camera names.
BagTopics choose_topics(const BagContents& contents, const OpenOptions& options, SourceInfo& info);

/// The topics of a type in order of their names.
std::vector<std::string> topics_of(const BagContents& contents, const std::string& type);

/// The camera of the main topic as its first CameraInfo has it; a warning where that cannot be used.
CalibratedCamera camera_of_topic(const BagTopics& topics, const BagContents& contents, SourceInfo& info);

/// Of the first image of the main topic; nullopt where it is broken.
std::optional<ImageSize> size_of_images(const BagTopics& topics, const BagContents& contents);

/// A warning where depth is in the bag, but most of the first frames have none by their stamps; "" otherwise.
std::string sparse_depth_warning(const BagTopics& topics, const std::string& path);

}  // namespace rastro
