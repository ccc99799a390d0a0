// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/time.h"

namespace rastro {

/// Writes an MCAP file (https://mcap.dev/spec, version 0): chunks without compression, each with its indexes, and a
/// summary at the end, so that readers find any time without reading the whole file. Every CRC is set. The same calls
/// give the same bytes.
class McapFile {
 public:
  using Facts = std::map<std::string, std::string>;
  static constexpr std::size_t default_chunk_bytes = 1 << 20;

  /// A chunk ends with the message that makes it as large as `chunk_bytes`. Bytes leave by `put`, in their order.
  explicit McapFile(PutPiece put, std::size_t chunk_bytes = default_chunk_bytes);
  McapFile(const McapFile&) = delete;
  McapFile& operator=(const McapFile&) = delete;

  /// Ids of schemas and channels count from 1. Schemas are Protobuf's: `data` is a FileDescriptorSet with the message
  /// `name` in it.
  std::uint16_t add_schema(const std::string& name, const std::string& data);
  std::uint16_t add_channel(std::uint16_t schema, const std::string& topic, const Facts& facts);
  /// `time` is at least 0; files open fastest where messages come in the order of time.
  void add_message(std::uint16_t channel, TimeNs time, std::string_view data);
  /// A record of its own about the whole file.
  void add_metadata(const std::string& name, const Facts& facts);
  /// Writes the summary. Nothing may be added afterwards.
  void finish();

 private:
  struct Channel {
    std::uint64_t messages = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  ///< Time and offset of messages in the open chunk.
    bool written = false;                                        ///< Its record, and that of its schema.
    std::uint16_t schema = 0;
  };
  struct Span {
    std::uint64_t first = 0, last = 0;
    void include(std::uint64_t time, bool is_first);
  };

  void put_bytes(std::string_view bytes);
  void open_channel(Channel& channel, std::uint16_t id);
  void end_chunk();
  void add_chunk_index(std::uint64_t start, std::uint64_t length);
  std::string message_indexes(std::string& offsets);
  std::string statistics() const;
  /// A group of the summary: its records, and a summary offset for the end.
  void put_group(std::uint8_t kind, std::string_view records, std::string& offsets);

  PutPiece put_;
  std::size_t chunk_bytes_;
  std::uint64_t written_ = 0;  ///< Bytes.
  std::uint32_t crc_ = 0;      ///< Of the section being written.
  std::string chunk_;          ///< Records of the open one.
  std::uint64_t chunk_messages_ = 0, chunks_ = 0, messages_ = 0, metadata_ = 0;
  Span chunk_span_, span_;
  std::vector<std::string> schemas_;          ///< Records, by id from 1.
  std::vector<bool> schema_written_;          ///< In a chunk.
  std::vector<std::string> channel_records_;  ///< By id from 1.
  std::vector<Channel> channels_;
  std::string chunk_indexes_, metadata_indexes_;
};

}  // namespace rastro
