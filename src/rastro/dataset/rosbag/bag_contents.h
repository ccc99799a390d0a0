// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <map>
#include <set>
#include <string>

#include "rastro/dataset/rosbag/bag_records.h"

namespace rastro {

/// What a bag holds, known before its messages are read one by one.
struct BagContents {
  std::map<std::string, std::set<std::string>> topics_of_type;
  std::map<std::string, std::int64_t> message_count;  ///< Of each topic.
  std::map<std::string, BagMessage> first_message;    ///< Of each topic of images and calibrations.
  bool has_index = false;
};

/// From the index at the end of the bag; where that is missing or not sound, from all messages as far as the bag is
/// whole. Error where it is not a bag.
BagContents read_bag_contents(const std::string& path);

}  // namespace rastro
