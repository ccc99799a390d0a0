// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rastro/base/time.h"

namespace rastro {

/// One message of a bag as it was recorded.
struct BagMessage {
  std::string topic;
  std::string type;  ///< "sensor_msgs/LaserScan".
  std::string md5;   ///< Of the type's definition.
  TimeNs time = 0;   ///< When it was recorded.
  std::vector<std::uint8_t> bytes;
};

/// The messages of a ROS 1 bag (format 2.0) in the order of the file, which is that of recording. One chunk is in
/// memory at a time, nothing needs the index, and no byte is trusted: rosbag_storage refuses bags that were cut short
/// or never closed, and ends the program where sizes or offsets in a bag are damaged (an assert in
/// Buffer::ensureCapacity).
class BagRecords {
 public:
  struct Connection {
    std::string topic, type, md5;
  };

  /// Error where it is no such bag.
  explicit BagRecords(const std::string& path);

  /// What the index at the end says: each connection with its number of messages. nullopt where it is incomplete. The
  /// next message is then the first one of the bag.
  std::optional<std::vector<std::pair<Connection, std::int64_t>>> read_index();

  /// nullopt at the end, or where what follows is incomplete.
  std::optional<BagMessage> next();

 private:
  struct Record {
    std::map<std::string, std::string_view> fields;
    std::string_view data;
  };

  std::optional<Record> next_record();
  bool read_from_file();
  bool open_chunk(const Record& record);
  void keep_connection(const Record& record);
  std::optional<BagMessage> message_of(const Record& record) const;

  void go_to(std::uint64_t offset);

  std::ifstream file_;
  std::uint64_t file_size_ = 0;
  bool stopped_ = false;
  std::uint64_t left_in_file_ = 0;
  std::string header_, data_;  ///< Of the record read last from the file.
  std::string chunk_;
  std::string_view left_in_chunk_;
  std::map<std::uint32_t, Connection> connections_;
};

}  // namespace rastro
