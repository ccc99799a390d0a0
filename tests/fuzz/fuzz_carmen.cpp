// SPDX-License-Identifier: Apache-2.0
// A carmen log, line by line: each is a valid frame, no frame, or refused with rastro::Error; in both passes alike.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/dataset/laser_log/carmen.h"

namespace {

/// Numbers of the lines that are valid frames.
std::vector<std::int64_t> read_lines(rastro::LogParser& parser, std::string_view text) {
  std::vector<std::int64_t> frames;
  std::int64_t number = 0;
  for (const auto line : rastro::split(text, '\n')) {
    ++number;
    try {
      const auto frame = parser.read(line, {"input", number});
      if (!frame) continue;
      if (!frame->scan || frame->scan->ranges.size() > line.size()) __builtin_trap();
      if (frame->odometry_from_body && !frame->odometry_from_body->translation().allFinite()) __builtin_trap();
      if (!frame->scan->body_from_laser.translation().allFinite()) __builtin_trap();
      frames.push_back(number);
    } catch (const rastro::Error&) {
    }
  }
  return frames;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  rastro::CarmenParser parser;
  const auto first = read_lines(parser, text);
  rastro::SourceInfo info;
  parser.start_over(info);
  if (read_lines(parser, text) != first) __builtin_trap();
  return 0;
}
