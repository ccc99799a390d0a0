// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/jpeg_stream.h"

#include <algorithm>
#include <cstdint>

namespace rastro {
namespace {

// ISO/IEC 10918-1, table B.1.
constexpr unsigned char mark = 0xFF, start_of_image = 0xD8, end_of_image = 0xD9, start_of_scan = 0xDA;
constexpr std::size_t largest_jpeg = std::size_t{64} << 20;

bool is_restart(unsigned char code) { return code >= 0xD0 && code <= 0xD7; }

/// Where the coded data that begins at `at` ends: at the next marker that is neither stuffing nor a restart.
std::size_t end_of_scan(std::span<const unsigned char> bytes, std::size_t at) {
  for (; at + 1 < bytes.size(); ++at)
    if (bytes[at] == mark && bytes[at + 1] != 0 && bytes[at + 1] != mark && !is_restart(bytes[at + 1])) return at;
  return bytes.size();
}

}  // namespace

std::optional<std::size_t> jpeg_length(std::span<const unsigned char> bytes) {
  if (bytes.size() < 2) return std::nullopt;
  if (bytes[0] != mark || bytes[1] != start_of_image) return 0;
  std::size_t at = 2;
  while (at + 2 <= bytes.size()) {
    if (bytes[at] != mark) return 0;
    const unsigned char code = bytes[at + 1];
    if (code == end_of_image) return at + 2;
    if (code == mark) {  // filling
      ++at;
      continue;
    }
    if (code == start_of_image || code == 0) return 0;
    if (at + 4 > bytes.size()) break;
    const std::size_t length = std::size_t{bytes[at + 2]} << 8 | bytes[at + 3];
    if (length < 2) return 0;
    at += 2 + length;
    if (code == start_of_scan && at < bytes.size()) at = end_of_scan(bytes, at);
  }
  return bytes.size() > largest_jpeg ? std::optional<std::size_t>(0) : std::nullopt;
}

std::optional<std::span<const unsigned char>> JpegStream::next() {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  constexpr unsigned char start[] = {mark, start_of_image};
  for (;;) {
    const auto found = std::search(buffer_.begin(), buffer_.end(), std::begin(start), std::end(start));
    const bool keeps_last = found == buffer_.end() && !buffer_.empty() && buffer_.back() == mark;
    buffer_.erase(buffer_.begin(), keeps_last ? buffer_.end() - 1 : found);
    const auto length = jpeg_length(buffer_);
    if (!length) return std::nullopt;
    if (*length > 0) {
      begin_ = *length;
      return std::span<const unsigned char>(buffer_).first(*length);
    }
    if (buffer_.size() < 2) return std::nullopt;
    buffer_.erase(buffer_.begin(), buffer_.begin() + 2);
  }
}

}  // namespace rastro
