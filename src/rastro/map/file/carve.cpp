// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/carve.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/regular_file.h"
#include "rastro/map/file/database.h"

namespace rastro {
namespace {

constexpr std::size_t page_size = 4096;  // as Database creates them
constexpr std::size_t first_page_header = 100;
constexpr std::size_t longest_row = 256U << 20;

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t number = 0;
  for (const char c : bytes) number = number << 8 | static_cast<unsigned char>(c);
  return number;
}

/// The pages of the file; pages in the log replace older ones.
class Pages {
 public:
  explicit Pages(const std::filesystem::path& file) {
    require_regular_file(file, largest_whole_file_bytes);
    file_.open(file, std::ios::binary);
    if (!file_) throw Error("cannot be read", file.string(), "check the path");
    file_.seekg(0, std::ios::end);
    count_ = (static_cast<std::uint64_t>(file_.tellg()) + page_size - 1) / page_size;
    log_.open(file.string() + "-wal", std::ios::binary);
    if (log_) index_log();
  }

  std::uint64_t count() const { return count_; }

  /// Page `number`, from 1; zeros beyond the end of the file.
  std::string page(std::uint64_t number) {
    std::string bytes(page_size, '\0');
    const auto logged = in_log_.find(number);
    if (logged != in_log_.end()) {
      read(log_, logged->second, bytes);
    } else if (number >= 1 && number <= count_) {
      read(file_, (number - 1) * page_size, bytes);
    }
    return bytes;
  }

 private:
  static bool read(std::ifstream& stream, std::uint64_t at, std::string& bytes) {
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(at));
    stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return static_cast<std::size_t>(stream.gcount()) == bytes.size();
  }

  /// Frames of the log's current generation have the salt of its header. Those after the last commit are used too: rows
  /// are verified by their checksums.
  void index_log() {
    constexpr std::size_t header_size = 32, frame_header_size = 24;
    std::string header(header_size, '\0'), frame(frame_header_size, '\0');
    if (!read(log_, 0, header)) return;
    for (std::uint64_t at = header_size; read(log_, at, frame); at += frame_header_size + page_size) {
      if (frame.substr(8, 8) != header.substr(16, 8)) return;
      const std::uint64_t number = big_endian(std::string_view(frame).substr(0, 4));
      in_log_[number] = at + frame_header_size;
      count_ = std::max(count_, number);
    }
  }

  std::ifstream file_, log_;
  std::uint64_t count_ = 0;
  std::map<std::uint64_t, std::uint64_t> in_log_;  ///< Page to position in the log.
};

/// Reads along a cell; nullopt beyond its end.
class Cell {
 public:
  explicit Cell(std::string_view bytes) : bytes_(bytes) {}

  std::optional<std::uint64_t> varint() {
    std::uint64_t value = 0;
    for (int i = 0; i < 9 && at_ < bytes_.size(); ++i) {
      const auto byte = static_cast<unsigned char>(bytes_[at_++]);
      if (i == 8) return value << 8 | byte;
      value = value << 7 | (byte & 0x7FU);
      if (byte < 0x80U) return value;
    }
    return std::nullopt;
  }
  std::optional<std::string_view> take(std::uint64_t size) {
    if (size > bytes_.size() - at_) return std::nullopt;
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  std::string_view rest() const { return bytes_.substr(at_); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

/// The payload of a cell, whose end may lie on overflow pages.
std::optional<std::string> payload_of(Pages& pages, std::string_view local, std::uint64_t size) {
  constexpr std::uint64_t most = page_size - 35, least = (page_size - 12) * 32 / 255 - 23, chained = page_size - 4;
  if (size > longest_row || size / page_size > pages.count()) return std::nullopt;
  if (size <= most) return size <= local.size() ? std::optional(std::string(local.substr(0, size))) : std::nullopt;
  const std::uint64_t wish = least + (size - least) % chained, kept = wish <= most ? wish : least;
  if (kept + 4 > local.size()) return std::nullopt;
  std::string payload(local.substr(0, kept));
  std::uint64_t next = big_endian(local.substr(kept, 4));
  while (payload.size() < size && next >= 1 && next <= pages.count()) {
    const std::string page = pages.page(next);
    payload += page.substr(4, std::min<std::uint64_t>(chained, size - payload.size()));
    next = big_endian(std::string_view(page).substr(0, 4));
  }
  return payload.size() == size ? std::optional(std::move(payload)) : std::nullopt;
}

struct Row {
  std::int64_t id = 0, checksum = 0;
  std::string body;
};

std::optional<std::int64_t> integer(Cell& record, std::uint64_t type) {
  constexpr std::uint64_t sizes[] = {0, 1, 2, 3, 4, 6, 8};
  if (type == 8 || type == 9) return type == 9 ? 1 : 0;
  if (type < 1 || type > 6) return std::nullopt;
  const auto bytes = record.take(sizes[type]);
  if (!bytes) return std::nullopt;
  const auto shift = static_cast<unsigned>(64 - 8 * sizes[type]);
  return static_cast<std::int64_t>(big_endian(*bytes) << shift) >> shift;
}

/// A record of three columns: the row's id (stored in the cell), an integer, a blob.
std::optional<Row> carved_row(const std::string& payload, std::uint64_t id) {
  Cell record(payload);
  std::uint64_t types[4] = {};
  for (std::uint64_t& type : types) {
    const auto value = record.varint();
    if (!value) return std::nullopt;
    type = *value;
  }
  if (types[1] != 0 || types[3] < 12 || types[3] % 2 != 0) return std::nullopt;
  const auto checksum = integer(record, types[2]);
  if (!checksum || record.rest().size() != (types[3] - 12) / 2) return std::nullopt;
  return Row{static_cast<std::int64_t>(id), *checksum, std::string(record.rest())};
}

std::optional<Row> row_at(Pages& pages, std::string_view page, std::size_t at) {
  Cell cell(page.substr(at));
  const auto size = cell.varint();
  const auto id = cell.varint();
  if (!size || !id) return std::nullopt;
  const auto payload = payload_of(pages, cell.rest(), *size);
  return payload ? carved_row(*payload, *id) : std::nullopt;
}

}  // namespace

void carve_rows(const std::filesystem::path& file, const std::vector<std::string>& tables,
                const std::function<void(const std::string& table, std::int64_t id, const std::string& body)>& found) {
  constexpr char table_leaf = 0x0D;
  constexpr std::size_t leaf_header = 8;
  Pages pages(file);
  for (std::uint64_t number = 1; number <= pages.count(); ++number) {
    const std::string page = pages.page(number);
    const std::size_t begin = number == 1 ? first_page_header : 0;
    if (page[begin] != table_leaf) continue;
    const std::uint64_t cells = big_endian(std::string_view(page).substr(begin + 3, 2));
    for (std::size_t i = 0; i < cells && begin + leaf_header + 2 * i + 2 <= page_size; ++i) {
      const std::uint64_t at = big_endian(std::string_view(page).substr(begin + leaf_header + 2 * i, 2));
      if (at >= page_size) continue;
      const auto row = row_at(pages, page, at);
      if (!row) continue;
      for (const std::string& table : tables)
        if (row_checksum(table, row->id, row->body) == row->checksum) found(table, row->id, row->body);
    }
  }
}

}  // namespace rastro
