// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/y4m.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro {
namespace {

constexpr std::string_view magic = "YUV4MPEG2";
constexpr std::size_t longest_line = 1024;
constexpr std::int64_t largest_side = 16384;

[[noreturn]] void refuse(const std::string& what, const char* advice) { throw Error(what, "Y4M stream", advice); }

struct NamedChroma {
  std::string_view begin;
  int x, y;
};
// Longer names first: "420p10" is not "420".
constexpr NamedChroma chromas[] = {{"420jpeg", 2, 2}, {"420mpeg2", 2, 2}, {"420paldv", 2, 2}, {"420", 2, 2},
                                   {"422", 2, 1},     {"444", 1, 1},      {"mono", 0, 0}};

void set_chroma(Y4mHeader& header, std::string_view name) {
  for (const NamedChroma& each : chromas) {
    if (name != each.begin) continue;
    header.chroma_x = each.x;
    header.chroma_y = each.y;
    return;
  }
  refuse(fmt::format("the colors {} are not supported", in_quotes(std::string(name))),
         "give 8 bit: 'ffmpeg ... -pix_fmt yuv420p -f yuv4mpegpipe -'");
}

int side(std::string_view text) {
  const auto value = parse_int64(text);
  if (!value || *value < 1 || *value > largest_side)
    refuse(fmt::format("{} is not a width or height", in_quotes(std::string(text))), "");
  return static_cast<int>(*value);
}

double rate(std::string_view text) {
  const auto numbers = split(text, ':');
  if (numbers.size() != 2) return 0.0;
  const auto over = parse_int64(numbers[0]), under = parse_int64(numbers[1]);
  return over && under && *over > 0 && *under > 0 ? static_cast<double>(*over) / static_cast<double>(*under) : 0.0;
}

std::size_t divided_up(int size, int by) { return by == 0 ? 0 : static_cast<std::size_t>((size + by - 1) / by); }

}  // namespace

std::size_t Y4mHeader::chroma_width() const { return divided_up(width, chroma_x); }
std::size_t Y4mHeader::chroma_height() const { return divided_up(height, chroma_y); }
std::size_t Y4mHeader::frame_bytes() const { return luma_bytes() + 2 * chroma_width() * chroma_height(); }

Y4mHeader parse_y4m_header(std::string_view line) {
  const auto words = split_words(line);
  if (words.empty() || words.front() != magic) refuse("does not begin with YUV4MPEG2", "is it Y4M?");
  Y4mHeader header;
  for (std::size_t k = 1; k < words.size(); ++k) {
    const std::string_view word = words[k], value = word.substr(1);
    switch (word.front()) {
      case 'W':
        header.width = side(value);
        break;
      case 'H':
        header.height = side(value);
        break;
      case 'F':
        header.rate_hz = rate(value);
        break;
      case 'C':
        set_chroma(header, value);
        break;
      case 'I':
        if (value != "p" && value != "?") refuse("is interlaced", "give whole frames: 'ffmpeg ... -vf yadif'");
        break;
      case 'X':
        header.full_range = header.full_range || value == "COLORRANGE=FULL";
        break;
      default:
        break;
    }
  }
  if (header.width == 0 || header.height == 0) refuse("tells no width or height", "");
  return header;
}

std::optional<std::span<const unsigned char>> Y4mStream::next() {
  drop_used();
  if (!header_) {
    const auto line = take_line(longest_line);
    if (!line) return std::nullopt;
    header_ = parse_y4m_header(*line);
  }
  if (!in_frame_) {
    const auto line = take_line(longest_line);
    if (!line) return std::nullopt;
    if (!line->starts_with("FRAME")) refuse("has no FRAME where the next image should begin", "it is damaged");
    in_frame_ = true;
  }
  const std::size_t bytes = header_->frame_bytes();
  if (size() < bytes) return std::nullopt;
  const std::span<const unsigned char> image{buffer_.data() + begin_, bytes};
  begin_ += bytes;
  in_frame_ = false;
  return image;
}

std::optional<std::string_view> Y4mStream::take_line(std::size_t most) {
  const auto first = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_);
  const auto end = std::find(first, buffer_.end(), '\n');
  const auto length = static_cast<std::size_t>(end - first);
  if (length > most) refuse(fmt::format("has a line of more than {} bytes", most), "it is damaged");
  if (end == buffer_.end()) return std::nullopt;
  const std::string_view line{reinterpret_cast<const char*>(buffer_.data()) + begin_, length};
  begin_ += length + 1;
  return line;
}

/// Only between images: what the last call gave must stay until then.
void Y4mStream::drop_used() {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
}

}  // namespace rastro
