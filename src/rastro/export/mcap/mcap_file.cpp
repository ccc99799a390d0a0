// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/mcap/mcap_file.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/base/version.h"
#include "rastro/export/raw_bytes.h"

namespace rastro {
namespace {

using detail::append_raw;

constexpr std::string_view magic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t head_bytes = 9;  // kind and length of a record

enum McapRecord : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  statistics_record = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

std::uint32_t crc_of(std::uint32_t before, std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<z_size_t>(bytes.size())));
}

void append_text(std::string& bytes, std::string_view text) {
  append_raw(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

void append_facts(std::string& bytes, const McapFile::Facts& facts) {
  std::string pairs;
  for (const auto& [key, value] : facts) {
    append_text(pairs, key);
    append_text(pairs, value);
  }
  append_text(bytes, pairs);
}

void append_head(std::string& bytes, std::uint8_t kind, std::uint64_t length) {
  append_raw(bytes, kind);
  append_raw(bytes, length);
}

std::string record(std::uint8_t kind, std::string_view content) {
  std::string bytes;
  bytes.reserve(head_bytes + content.size());
  append_head(bytes, kind, content.size());
  bytes += content;
  return bytes;
}

std::string joined(const std::vector<std::string>& records) {
  std::string all;
  for (const std::string& each : records) all += each;
  return all;
}

}  // namespace

McapFile::McapFile(PutPiece put, std::size_t chunk_bytes) : put_(std::move(put)), chunk_bytes_(chunk_bytes) {
  std::string content;
  append_text(content, "");  // no profile: channels explain themselves
  append_text(content, "rastro " + version().number);
  put_bytes(magic);
  put_bytes(record(header, content));
}

void McapFile::Span::include(std::uint64_t time, bool is_first) {
  first = is_first ? time : std::min(first, time);
  last = is_first ? time : std::max(last, time);
}

void McapFile::put_bytes(std::string_view bytes) {
  put_(bytes);
  crc_ = crc_of(crc_, bytes);
  written_ += bytes.size();
}

std::uint16_t McapFile::add_schema(const std::string& name, const std::string& data) {
  RASTRO_CHECK(schemas_.size() < std::numeric_limits<std::uint16_t>::max(), "ids of schemas have 16 bits");
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
  std::string content;
  append_raw(content, id);
  append_text(content, name);
  append_text(content, "protobuf");
  append_text(content, data);
  schemas_.push_back(record(schema, content));
  schema_written_.push_back(false);
  return id;
}

std::uint16_t McapFile::add_channel(std::uint16_t of_schema, const std::string& topic, const Facts& facts) {
  RASTRO_CHECK(of_schema >= 1 && of_schema <= schemas_.size(), "a channel has a schema");
  RASTRO_CHECK(channels_.size() < std::numeric_limits<std::uint16_t>::max(), "ids of channels have 16 bits");
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  std::string content;
  append_raw(content, id);
  append_raw(content, of_schema);
  append_text(content, topic);
  append_text(content, "protobuf");
  append_facts(content, facts);
  channel_records_.push_back(record(channel, content));
  channels_.emplace_back();
  channels_.back().schema = of_schema;
  return id;
}

/// Its records stand in the chunk with its first message, so that a file that was cut off can be read up to there.
void McapFile::open_channel(Channel& of, std::uint16_t id) {
  const auto row = static_cast<std::size_t>(of.schema) - 1;
  if (!schema_written_[row]) chunk_ += schemas_[row];
  schema_written_[row] = true;
  chunk_ += channel_records_[static_cast<std::size_t>(id) - 1];
  of.written = true;
}

void McapFile::add_message(std::uint16_t channel_id, TimeNs time, std::string_view data) {
  RASTRO_CHECK(channel_id >= 1 && channel_id <= channels_.size(), "a message has a channel");
  RASTRO_CHECK(time >= 0, "times of MCAP are not negative");
  Channel& of = channels_[static_cast<std::size_t>(channel_id) - 1];
  if (!of.written) open_channel(of, channel_id);
  const auto log_time = static_cast<std::uint64_t>(time);
  of.index.emplace_back(log_time, chunk_.size());
  std::string content;
  append_raw(content, channel_id);
  append_raw(content, static_cast<std::uint32_t>(of.messages));
  append_raw(content, log_time);
  append_raw(content, log_time);  // published: the same
  append_head(chunk_, message, content.size() + data.size());
  chunk_ += content;
  chunk_ += data;
  chunk_span_.include(log_time, chunk_messages_++ == 0);
  span_.include(log_time, messages_++ == 0);
  ++of.messages;
  if (chunk_.size() >= chunk_bytes_) end_chunk();
}

/// Records of the open chunk's messages by channel; `offsets` says where each begins, for the chunk's own index.
std::string McapFile::message_indexes(std::string& offsets) {
  std::string indexes;
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    auto& index = channels_[k].index;
    if (index.empty()) continue;
    std::stable_sort(index.begin(), index.end());
    const auto id = static_cast<std::uint16_t>(k + 1);
    append_raw(offsets, id);
    append_raw(offsets, written_ + indexes.size());
    std::string entries, content;
    for (const auto& [time, offset] : index) {
      append_raw(entries, time);
      append_raw(entries, offset);
    }
    append_raw(content, id);
    append_text(content, entries);
    indexes += record(message_index, content);
    index.clear();
  }
  return indexes;
}

void McapFile::end_chunk() {
  if (chunk_messages_ == 0) return;
  const std::uint64_t start = written_, bytes = chunk_.size();
  std::string front;
  append_raw(front, chunk_span_.first);
  append_raw(front, chunk_span_.last);
  append_raw(front, bytes);
  append_raw(front, crc_of(0, chunk_));
  append_text(front, "");  // not compressed
  append_raw(front, bytes);
  std::string head;
  append_head(head, chunk, front.size() + bytes);
  put_bytes(head + front);
  put_bytes(chunk_);
  add_chunk_index(start, written_ - start);
  chunk_.clear();
  chunk_messages_ = 0;
  ++chunks_;
}

/// Writes the indexes of the chunk that ends here, and keeps one of it all for the summary.
void McapFile::add_chunk_index(std::uint64_t start, std::uint64_t length) {
  std::string offsets, entry;
  const std::string indexes = message_indexes(offsets);
  put_bytes(indexes);
  for (const std::uint64_t each : {chunk_span_.first, chunk_span_.last, start, length}) append_raw(entry, each);
  append_text(entry, offsets);
  append_raw(entry, static_cast<std::uint64_t>(indexes.size()));
  append_text(entry, "");
  for (int k = 0; k < 2; ++k) append_raw(entry, static_cast<std::uint64_t>(chunk_.size()));  // as stored, and as read
  chunk_indexes_ += record(chunk_index, entry);
}

void McapFile::add_metadata(const std::string& name, const Facts& facts) {
  std::string content;
  append_text(content, name);
  append_facts(content, facts);
  const std::string bytes = record(metadata, content);
  std::string entry;
  append_raw(entry, written_);
  append_raw(entry, static_cast<std::uint64_t>(bytes.size()));
  append_text(entry, name);
  metadata_indexes_ += record(metadata_index, entry);
  put_bytes(bytes);
  ++metadata_;
}

std::string McapFile::statistics() const {
  std::string counts, content;
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    append_raw(counts, static_cast<std::uint16_t>(k + 1));
    append_raw(counts, channels_[k].messages);
  }
  append_raw(content, messages_);
  append_raw(content, static_cast<std::uint16_t>(schemas_.size()));
  append_raw(content, static_cast<std::uint32_t>(channels_.size()));
  append_raw(content, std::uint32_t{0});  // attachments
  append_raw(content, static_cast<std::uint32_t>(metadata_));
  append_raw(content, static_cast<std::uint32_t>(chunks_));
  append_raw(content, span_.first);
  append_raw(content, span_.last);
  append_text(content, counts);
  return record(statistics_record, content);
}

void McapFile::put_group(std::uint8_t kind, std::string_view records, std::string& offsets) {
  if (records.empty()) return;
  std::string content;
  append_raw(content, kind);
  append_raw(content, written_);
  append_raw(content, static_cast<std::uint64_t>(records.size()));
  offsets += record(summary_offset, content);
  put_bytes(records);
}

void McapFile::finish() {
  end_chunk();
  std::string end;
  append_raw(end, crc_);
  put_bytes(record(data_end, end));

  crc_ = 0;
  const std::uint64_t summary = written_;
  std::string offsets;
  put_group(schema, joined(schemas_), offsets);
  put_group(channel, joined(channel_records_), offsets);
  put_group(statistics_record, statistics(), offsets);
  put_group(chunk_index, chunk_indexes_, offsets);
  put_group(metadata_index, metadata_indexes_, offsets);
  const std::uint64_t summary_offsets = written_;
  put_bytes(offsets);
  constexpr std::uint64_t footer_bytes = 20;
  std::string last;
  append_head(last, footer, footer_bytes);
  append_raw(last, summary);
  append_raw(last, summary_offsets);
  put_bytes(last);
  std::string crc;
  append_raw(crc, crc_);
  put_bytes(crc);
  put_bytes(magic);
}

}  // namespace rastro
