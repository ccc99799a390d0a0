// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_ROSBAG

#include "rastro/dataset/rosbag/bag_topics.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/text.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/dataset/rosbag/bag_messages.h"
#include "rastro/dataset/rosbag/bag_stream.h"
#include "rastro/image/image_header.h"

namespace rastro {
namespace {

std::string text_of(const BagContents& contents) {
  std::vector<std::string> lines;
  for (const auto& [type, topics] : contents.topics_of_type)
    lines.push_back(fmt::format("{} ({})", fmt::join(topics, ", "), type));
  return lines.empty() ? "no topics" : one_line(fmt::format("{}", fmt::join(lines, "; ")), 400);
}

/// What `judge` says of the first message of a topic; false where it is missing or broken.
template <typename Message, typename Judge>
bool first_message_is(const BagContents& contents, const std::string& topic, Judge judge) {
  const auto first = contents.first_message.find(topic);
  if (first == contents.first_message.end()) return false;
  try {
    return judge(decode<Message>(first->second, topic));
  } catch (const Error&) {
    return false;
  }
}

bool is_depth_topic(const BagContents& contents, const std::string& topic) {
  return first_message_is<ImageMessage>(contents, topic, [](const auto& message) { return is_depth(message); });
}

bool is_png_depth_topic(const BagContents& contents, const std::string& topic) {
  return first_message_is<CompressedMessage>(contents, topic, [](const auto& message) { return is_depth(message); });
}

bool is_packed_depth_topic(const BagContents& contents, const std::string& topic) {
  return first_message_is<CompressedMessage>(contents, topic,
                                             [](const auto& message) { return is_packed_depth(message); });
}

/// The first of them; a warning where others were left.
std::string first_of(const std::vector<std::string>& topics, std::vector<std::string>& warnings) {
  if (topics.empty()) return "";
  if (topics.size() > 1)
    warnings.push_back(
        fmt::format("topic {} is read, not {}", topics.front(), fmt::join(topics.begin() + 1, topics.end(), ", ")));
  return topics.front();
}

/// The first topic by name of this type that `wanted` accepts.
template <typename Wanted>
std::string first_topic(const BagContents& contents, const std::string& type, std::vector<std::string>& warnings,
                        Wanted wanted) {
  std::vector<std::string> topics = topics_of(contents, type);
  std::erase_if(topics, [&](const std::string& topic) { return !wanted(topic); });
  return first_of(topics, warnings);
}

bool any(const std::string&) { return true; }

/// The image topic that --camera names, whichever kind it is.
void choose_camera(BagTopics& topics, const BagContents& contents, const std::string& wanted, const std::string& path) {
  const auto images = topics_of(contents, "sensor_msgs/Image"),
             packed = topics_of(contents, "sensor_msgs/CompressedImage");
  if (std::find(images.begin(), images.end(), wanted) != images.end()) {
    topics.image = wanted;
  } else if (std::find(packed.begin(), packed.end(), wanted) != packed.end()) {
    topics.compressed = wanted;
  } else {
    throw Error(fmt::format("there is no image topic {}", in_quotes(wanted)), path, "it has " + text_of(contents));
  }
}

void choose_main(BagTopics& topics, const BagContents& contents, const OpenOptions& options, SourceInfo& info) {
  if (!options.camera.empty()) return choose_camera(topics, contents, options.camera, info.path);
  const auto bright = [&](const std::string& topic) { return !is_depth_topic(contents, topic); };
  const auto no_depth = [&](const std::string& topic) {
    return topic.find("epth") == std::string::npos && !is_packed_depth_topic(contents, topic);
  };
  topics.scan = first_topic(contents, "sensor_msgs/LaserScan", info.warnings, any);
  if (topics.scan.empty()) topics.image = first_topic(contents, "sensor_msgs/Image", info.warnings, bright);
  if (topics.main().empty())
    topics.compressed = first_topic(contents, "sensor_msgs/CompressedImage", info.warnings, no_depth);
  if (topics.main().empty())
    throw Error("has neither laser scans nor images", info.path, "it has " + text_of(contents));
}

/// As drivers name depth that they have put into the color image.
bool is_registered(const std::string& topic) {
  return topic.find("registered") != std::string::npos || topic.find("aligned") != std::string::npos;
}

/// Depth as its own camera sees it is of use to those who ask for it and to calibrations that say where that camera is.
bool wants_registered(const OpenOptions& options) {
  if (options.raw_depth) return false;
  return options.calibration_file.empty() || !read_calibration(options.calibration_file).depth;
}

/// Registered depth first (where it is wanted), then what is not packed, then by name.
std::string choose_depth(const BagTopics& topics, const BagContents& contents, const OpenOptions& options,
                         SourceInfo& info) {
  std::vector<std::string> found, unread;
  for (const auto& topic : topics_of(contents, "sensor_msgs/Image"))
    if (topic != topics.image && is_depth_topic(contents, topic)) found.push_back(topic);
  for (const auto& topic : topics_of(contents, "sensor_msgs/CompressedImage")) {
    if (topic == topics.compressed || !is_packed_depth_topic(contents, topic)) continue;
    (is_png_depth_topic(contents, topic) ? found : unread).push_back(topic);
  }
  if (found.size() > 1) {
    const bool registered = wants_registered(options);
    std::stable_partition(found.begin(), found.end(),
                          [&](const std::string& topic) { return is_registered(topic) == registered; });
  }
  if (found.empty() && !unread.empty())
    info.warnings.push_back(fmt::format("depth is not read from {}: it is not packed as PNG", fmt::join(unread, ", ")));
  return first_of(found, info.warnings);
}

std::string choose_camera_info(const BagTopics& topics, const BagContents& contents, SourceInfo& info) {
  const std::string folder = topics.main().substr(0, topics.main().rfind('/') + 1);
  // Packed images stand one level below: /camera/image_raw/compressed.
  return first_topic(contents, "sensor_msgs/CameraInfo", info.warnings, [&](const std::string& topic) {
    return topic == folder + "camera_info" || topics.compressed.starts_with(topic.substr(0, topic.rfind('/') + 1));
  });
}

}  // namespace

std::vector<std::string> topics_of(const BagContents& contents, const std::string& type) {
  const auto found = contents.topics_of_type.find(type);
  if (found == contents.topics_of_type.end()) return {};
  return {found->second.begin(), found->second.end()};
}

BagTopics choose_topics(const BagContents& contents, const OpenOptions& options, SourceInfo& info) {
  BagTopics topics;
  choose_main(topics, contents, options, info);
  if (topics.scan.empty()) {
    topics.depth = choose_depth(topics, contents, options, info);
    topics.camera_info = choose_camera_info(topics, contents, info);
  }
  topics.odometry = first_topic(contents, "nav_msgs/Odometry", info.warnings, any);
  topics.imu = first_topic(contents, "sensor_msgs/Imu", info.warnings, any);
  return topics;
}

CalibratedCamera camera_of_topic(const BagTopics& topics, const BagContents& contents, SourceInfo& info) {
  CalibratedCamera camera;
  camera.name = topics.main();
  const auto first = contents.first_message.find(topics.camera_info);
  if (first == contents.first_message.end()) return camera;
  const bool rectified = topics.main().find("rect") != std::string::npos;
  try {
    const std::string& where = topics.camera_info;
    camera.camera = camera_of(decode<CameraMessage>(first->second, where), rectified, where);
  } catch (const Error& error) {
    info.warnings.push_back(std::string("the calibration in the bag is not used: ") + error.what());
  }
  if (camera.camera) camera.calibration_file = topics.camera_info;
  return camera;
}

std::optional<ImageSize> size_of_images(const BagTopics& topics, const BagContents& contents) {
  const auto first = contents.first_message.find(topics.main());
  if (first == contents.first_message.end()) return std::nullopt;
  try {
    if (!topics.compressed.empty()) {
      const auto message = decode<CompressedMessage>(first->second, topics.compressed);
      const auto size = image_header_size({message.data.data(), message.data.size()});
      if (!size || size->width * size->height == 0 || size->width * size->height > largest_image_pixels)
        return std::nullopt;
      return ImageSize{static_cast<int>(size->width), static_cast<int>(size->height)};
    }
    const auto image = image_of(decode<ImageMessage>(first->second, topics.image), false, topics.image);
    return ImageSize{image.gray.width(), image.gray.height()};
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string sparse_depth_warning(const BagTopics& topics, const std::string& path) {
  constexpr int most_frames = 20, most_looked_at = 200;
  BagStream stream(path, {topics.main()}, topics.depth);
  int frames = 0, with_depth = 0;
  for (int looked_at = 0; frames < most_frames && looked_at < most_looked_at; ++looked_at) {
    const auto message = stream.next();
    if (!message) break;
    const bool found = stream.depth_near(stamp_of(*message), message->time) != nullptr;
    if (!found && !stream.has_past_depth()) continue;  // The depth camera is not running yet.
    ++frames;
    with_depth += found ? 1 : 0;
  }
  if (2 * with_depth >= frames) return "";
  return fmt::format("{} of the first {} frames have a depth image of {} within 0.02 s by their stamps", with_depth,
                     frames, topics.depth);
}

}  // namespace rastro

#endif
