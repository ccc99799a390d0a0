// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_ROSBAG

#include "rastro/dataset/rosbag/bag_contents.h"

namespace rastro {
namespace {

bool is_kept(const std::string& type) {
  return type == "sensor_msgs/Image" || type == "sensor_msgs/CompressedImage" || type == "sensor_msgs/CameraInfo";
}

void keep_first(BagContents& contents, BagMessage message) {
  if (is_kept(message.type)) contents.first_message.try_emplace(message.topic, std::move(message));
}

/// How many topics of the kept types have messages at all.
std::size_t count_kept(const BagContents& contents) {
  std::size_t count = 0;
  for (const auto& [type, topics] : contents.topics_of_type) {
    if (!is_kept(type)) continue;
    for (const auto& topic : topics) count += contents.message_count.at(topic) > 0 ? 1 : 0;
  }
  return count;
}

}  // namespace

BagContents read_bag_contents(const std::string& path) {
  BagContents contents;
  BagRecords records(path);
  if (const auto index = records.read_index()) {
    contents.has_index = true;
    for (const auto& [connection, count] : *index) {
      contents.topics_of_type[connection.type].insert(connection.topic);
      contents.message_count[connection.topic] += count;
    }
    const std::size_t kept = count_kept(contents);
    while (contents.first_message.size() < kept) {
      auto message = records.next();
      if (!message) break;
      keep_first(contents, std::move(*message));
    }
    return contents;
  }
  while (auto message = records.next()) {
    contents.topics_of_type[message->type].insert(message->topic);
    ++contents.message_count[message->topic];
    keep_first(contents, std::move(*message));
  }
  return contents;
}

}  // namespace rastro

#endif
