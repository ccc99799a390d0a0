// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/laser_log/open_log.h"

#include <filesystem>

#include "rastro/dataset/folder.h"
#include "rastro/dataset/landmark_log/landmark_log.h"
#include "rastro/dataset/landmark_log/open_landmark_log.h"
#include "rastro/dataset/laser_log/carmen.h"
#include "rastro/dataset/laser_log/log_lines.h"
#include "rastro/dataset/laser_log/minesrover.h"
#include "rastro/dataset/rosbag/rosbag.h"

namespace rastro {

std::unique_ptr<Source> open_log(const std::string& path, const OpenOptions& options) {
  if (auto robot = open_mrclam(path, options)) return robot;
  if (is_rosbag(path)) return open_rosbag(path, options);
  if (const auto log = std::filesystem::path(path) / "scans.log"; is_file(log)) return open_log(log.string(), options);
  if (!is_file(path) || has_image_ending(path) || has_video_ending(path)) return nullptr;
  const auto front = text_at_front(path);
  if (looks_like_carmen(front)) return make_log_source(path, std::make_unique<CarmenParser>(), options);
  if (looks_like_minesrover(front)) return make_log_source(path, std::make_unique<MinesroverParser>(), options);
  if (looks_like_landmark_log(front)) return open_landmark_log(path, options);
  return nullptr;
}

}  // namespace rastro
