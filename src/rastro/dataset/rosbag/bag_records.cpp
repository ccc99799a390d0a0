// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_ROSBAG

#include "rastro/dataset/rosbag/bag_records.h"

#include <bzlib.h>
#include <roslz4/lz4s.h>

#include <cstring>
#include <filesystem>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr std::string_view magic = "#ROSBAG V2.0\n";
constexpr char message_kind = 0x02, chunk_kind = 0x05, chunk_info_kind = 0x06, connection_kind = 0x07;
constexpr std::uint32_t largest_chunk = 1U << 28;

/// Little-endian, as the format has all numbers; nullopt where the text has another size.
std::optional<std::uint32_t> number_of(std::string_view bytes) {
  if (bytes.size() != 4) return std::nullopt;
  std::uint32_t number = 0;
  for (std::size_t k = 4; k-- > 0;) number = number << 8 | static_cast<std::uint8_t>(bytes[k]);
  return number;
}

std::optional<std::uint64_t> offset_of(std::string_view bytes) {
  if (bytes.size() != 8) return std::nullopt;
  return *number_of(bytes.substr(0, 4)) | std::uint64_t{*number_of(bytes.substr(4))} << 32;
}

/// Cuts off four bytes of size and what they say; nullopt where it is incomplete.
std::optional<std::string_view> cut_sized(std::string_view& bytes) {
  const auto size = number_of(bytes.substr(0, 4));
  if (!size || bytes.size() - 4 < *size) return std::nullopt;
  const auto piece = bytes.substr(4, *size);
  bytes.remove_prefix(4 + std::size_t{*size});
  return piece;
}

std::map<std::string, std::string_view> fields_of(std::string_view header) {
  std::map<std::string, std::string_view> fields;
  while (const auto field = cut_sized(header)) {
    const auto equals = field->find('=');
    if (equals != std::string_view::npos) fields[std::string(field->substr(0, equals))] = field->substr(equals + 1);
  }
  return fields;
}

std::string_view field(const std::map<std::string, std::string_view>& fields, const char* name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string_view() : found->second;
}

char kind_of(const std::map<std::string, std::string_view>& fields) {
  const auto kind = field(fields, "op");
  return kind.size() == 1 ? kind.front() : '\0';
}

bool unpack(std::string_view kind, std::string_view packed, std::string& chunk) {
  if (kind == "none") {
    chunk = packed;
    return true;
  }
  auto size = static_cast<unsigned>(chunk.size());
  if (kind == "lz4")
    return roslz4_buffToBuffDecompress(const_cast<char*>(packed.data()), static_cast<unsigned>(packed.size()),
                                       chunk.data(), &size) == ROSLZ4_OK;
  return kind == "bz2" && BZ2_bzBuffToBuffDecompress(chunk.data(), &size, const_cast<char*>(packed.data()),
                                                     static_cast<unsigned>(packed.size()), 0, 0) == BZ_OK;
}

}  // namespace

BagRecords::BagRecords(const std::string& path) : file_(path, std::ios::binary) {
  std::string front(magic.size(), '\0');
  file_.read(front.data(), static_cast<std::streamsize>(front.size()));
  if (!file_ || front != magic) throw Error("is not a ROS 1 bag of format 2.0", path, "");
  std::error_code problem;
  const auto size = std::filesystem::file_size(path, problem);
  if (problem || size < magic.size()) throw Error("cannot be read", path, "");
  file_size_ = size;
  go_to(magic.size());
}

void BagRecords::go_to(std::uint64_t offset) {
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(offset));
  left_in_file_ = file_size_ - offset;
}

std::optional<std::vector<std::pair<BagRecords::Connection, std::int64_t>>> BagRecords::read_index() {
  go_to(magic.size());
  std::optional<std::uint64_t> offset;
  std::optional<std::uint32_t> connections, chunks;
  if (read_from_file()) {
    const auto fields = fields_of(header_);
    offset = offset_of(field(fields, "index_pos"));
    connections = number_of(field(fields, "conn_count"));
    chunks = number_of(field(fields, "chunk_count"));
  }
  std::map<std::uint32_t, std::int64_t> counts;
  std::uint32_t chunks_found = 0;
  if (offset && *offset > magic.size() && *offset <= file_size_) {
    go_to(*offset);
    while (read_from_file()) {
      const Record record{fields_of(header_), data_};
      if (kind_of(record.fields) == connection_kind) keep_connection(record);
      if (kind_of(record.fields) != chunk_info_kind) continue;
      ++chunks_found;
      for (std::string_view pairs = record.data; pairs.size() >= 8; pairs.remove_prefix(8))
        counts[*number_of(pairs.substr(0, 4))] += *number_of(pairs.substr(4, 4));
    }
  }
  const bool whole = offset && connections == connections_.size() && chunks == chunks_found && left_in_file_ == 0;
  go_to(magic.size());
  if (!whole) return std::nullopt;
  std::vector<std::pair<Connection, std::int64_t>> index;
  for (const auto& [number, connection] : connections_) index.emplace_back(connection, counts[number]);
  return index;
}

/// Reads one record into header_ and data_; false where the file has no whole one.
bool BagRecords::read_from_file() {
  for (std::string* part : {&header_, &data_}) {
    std::string size(4, '\0');
    file_.read(size.data(), 4);
    const auto bytes = number_of(size);
    if (!file_ || !bytes || left_in_file_ < std::uint64_t{4} + *bytes) return false;
    part->resize(*bytes);
    file_.read(part->data(), static_cast<std::streamsize>(*bytes));
    if (!file_) return false;
    left_in_file_ -= std::uint64_t{4} + *bytes;
  }
  return true;
}

bool BagRecords::open_chunk(const Record& record) {
  const auto size = number_of(field(record.fields, "size"));
  if (!size || *size > largest_chunk) return false;
  chunk_.assign(*size, '\0');
  if (!unpack(field(record.fields, "compression"), record.data, chunk_)) return false;
  left_in_chunk_ = chunk_;
  return true;
}

void BagRecords::keep_connection(const Record& record) {
  const auto number = number_of(field(record.fields, "conn"));
  if (!number) return;
  const auto about = fields_of(record.data);
  connections_[*number] = {std::string(field(record.fields, "topic")), std::string(field(about, "type")),
                           std::string(field(about, "md5sum"))};
}

std::optional<BagMessage> BagRecords::message_of(const Record& record) const {
  const auto number = number_of(field(record.fields, "conn"));
  const auto time = field(record.fields, "time");
  const auto seconds = number_of(time.substr(0, 4));
  const auto nanoseconds = time.size() == 8 ? number_of(time.substr(4)) : std::nullopt;
  if (!number || !seconds || !nanoseconds) return std::nullopt;
  const auto connection = connections_.find(*number);
  if (connection == connections_.end()) return std::nullopt;
  const auto& [topic, type, md5] = connection->second;
  return BagMessage{topic,
                    type,
                    md5,
                    TimeNs{*seconds} * ns_per_second + TimeNs{*nanoseconds},
                    {record.data.begin(), record.data.end()}};
}

std::optional<BagRecords::Record> BagRecords::next_record() {
  if (left_in_chunk_.empty()) {
    if (!read_from_file()) return std::nullopt;
    return Record{fields_of(header_), data_};
  }
  const auto header = cut_sized(left_in_chunk_);
  const auto data = header ? cut_sized(left_in_chunk_) : std::nullopt;
  if (!data) return std::nullopt;
  return Record{fields_of(*header), *data};
}

std::optional<BagMessage> BagRecords::next() {
  while (!stopped_) {
    const auto record = next_record();
    const char kind = record ? kind_of(record->fields) : '\0';
    // Behind what is incomplete no offset holds any more.
    if (!record || (kind == chunk_kind && !open_chunk(*record))) stopped_ = true;
    if (kind == connection_kind) keep_connection(*record);
    if (kind != message_kind) continue;
    if (auto found = message_of(*record)) return found;
  }
  return std::nullopt;
}

}  // namespace rastro

#endif
