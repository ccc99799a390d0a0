// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace rastro {

/// Takes values off the front of MCAP's bytes; std::out_of_range where they end early.
class McapCursor {
 public:
  explicit McapCursor(std::string_view bytes) : rest_(bytes) {}

  template <typename Value>
  Value number() {
    Value value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw std::out_of_range("MCAP ends early");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  std::string text() { return std::string(take(number<std::uint32_t>())); }
  std::map<std::string, std::string> facts() {
    McapCursor pairs(take(number<std::uint32_t>()));
    std::map<std::string, std::string> facts;
    while (!pairs.empty()) {
      const std::string key = pairs.text();
      facts[key] = pairs.text();
    }
    return facts;
  }
  std::string_view rest() const { return rest_; }
  bool empty() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

/// A record and where it begins.
struct McapRecordAt {
  std::uint8_t kind = 0;
  std::uint64_t offset = 0, bytes = 0;  ///< With its head.
  std::string_view content;
};

inline std::vector<McapRecordAt> mcap_records(std::string_view bytes, std::uint64_t offset) {
  std::vector<McapRecordAt> records;
  McapCursor cursor(bytes);
  while (!cursor.empty()) {
    McapRecordAt record;
    record.offset = offset + (bytes.size() - cursor.rest().size());
    record.kind = cursor.number<std::uint8_t>();
    record.content = cursor.take(cursor.number<std::uint64_t>());
    record.bytes = 9 + record.content.size();
    records.push_back(record);
  }
  return records;
}

struct McapMessageRead {
  std::string topic, schema;
  std::uint32_t sequence = 0;
  std::uint64_t time = 0;
  std::string_view data;
};

/// Reads a whole file from front to back, without its indexes.
struct McapFileRead {
  struct Channel {
    std::uint16_t schema = 0;
    std::string topic, encoding;
    std::map<std::string, std::string> facts;
  };
  struct Schema {
    std::string name, encoding, data;
  };
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<McapMessageRead> messages;
  std::map<std::string, std::map<std::string, std::string>> metadata;

  explicit McapFileRead(std::string_view file) {
    constexpr std::size_t magic = 8;
    for (const McapRecordAt& record : mcap_records(file.substr(magic, file.size() - 2 * magic), magic)) {
      if (record.kind == 0x06) read_chunk(record.content);
      if (record.kind == 0x0C) {
        McapCursor cursor(record.content);
        const std::string name = cursor.text();
        metadata[name] = cursor.facts();
      }
      if (record.kind == 0x0F) return;
    }
  }

  std::vector<McapMessageRead> of_topic(const std::string& topic) const {
    std::vector<McapMessageRead> found;
    for (const McapMessageRead& each : messages)
      if (each.topic == topic) found.push_back(each);
    return found;
  }

 private:
  void read_chunk(std::string_view content) {
    McapCursor cursor(content);
    cursor.take(28);
    cursor.text();
    for (const McapRecordAt& record : mcap_records(cursor.take(cursor.number<std::uint64_t>()), 0)) {
      McapCursor inner(record.content);
      const auto id = inner.number<std::uint16_t>();
      if (record.kind == 0x03) {
        Schema& schema = schemas[id];
        schema.name = inner.text();
        schema.encoding = inner.text();
        schema.data = inner.text();
      } else if (record.kind == 0x04) {
        Channel& channel = channels[id];
        channel.schema = inner.number<std::uint16_t>();
        channel.topic = inner.text();
        channel.encoding = inner.text();
        channel.facts = inner.facts();
      } else if (record.kind == 0x05) {
        const Channel& channel = channels.at(id);
        McapMessageRead message{channel.topic,
                                schemas.at(channel.schema).name,
                                inner.number<std::uint32_t>(),
                                inner.number<std::uint64_t>(),
                                {}};
        inner.number<std::uint64_t>();
        message.data = inner.rest();
        messages.push_back(message);
      }
    }
  }
};

}  // namespace rastro
