// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/image_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

namespace rastro {
namespace {

/// Numbers at any place; 0 beyond the end.
class HeaderBytes {
 public:
  explicit HeaderBytes(std::span<const unsigned char> bytes) : bytes_(bytes) {}

  std::uint64_t big(std::size_t at, std::size_t count) const {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < count; ++i) number = number << 8 | byte(at + i);
    return number;
  }
  std::uint64_t little(std::size_t at, std::size_t count) const {
    std::uint64_t number = 0;
    for (std::size_t i = count; i > 0; --i) number = number << 8 | byte(at + i - 1);
    return number;
  }
  bool starts_with(std::string_view text, std::size_t at = 0) const {
    return at + text.size() <= bytes_.size() && view().substr(at, text.size()) == text;
  }
  std::size_t size() const { return bytes_.size(); }
  std::string_view view() const { return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}; }
  std::uint64_t byte(std::size_t at) const { return at < bytes_.size() ? bytes_[at] : 0; }

 private:
  std::span<const unsigned char> bytes_;
};

/// The frame header (SOF0 to SOF15, without the tables DHT, JPG and DAC) among the segments.
std::optional<HeaderSize> jpeg_size(const HeaderBytes& bytes) {
  for (std::size_t at = 2; at + 9 <= bytes.size();) {
    if (bytes.byte(at) != 0xFF) return std::nullopt;
    const std::uint64_t marker = bytes.byte(at + 1);
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    if (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC)
      return HeaderSize{bytes.big(at + 7, 2), bytes.big(at + 5, 2)};
    at += 2 + bytes.big(at + 2, 2);
  }
  return std::nullopt;
}

/// Width and height follow the kind as words; '#' begins a comment.
std::optional<HeaderSize> pnm_size(std::string_view text) {
  std::uint64_t numbers[2] = {};
  std::size_t at = 2;
  for (std::uint64_t& number : numbers) {
    constexpr std::string_view blanks = " \t\r\n\f\v";
    while ((at = text.find_first_not_of(blanks, at)) != std::string_view::npos && text[at] == '#')
      at = std::min(text.find('\n', at), text.size());
    if (at == std::string_view::npos) return std::nullopt;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), number);
    if (error == std::errc::result_out_of_range) number = UINT32_MAX;
    if (error == std::errc::invalid_argument) return std::nullopt;
    at = static_cast<std::size_t>(end - text.data());
  }
  return HeaderSize{numbers[0], numbers[1]};
}

/// Tags 256 and 257 of the first directory.
std::optional<HeaderSize> tiff_size(const HeaderBytes& bytes) {
  const bool big = bytes.starts_with("MM");
  const auto number = [&](std::size_t at, std::size_t count) {
    return big ? bytes.big(at, count) : bytes.little(at, count);
  };
  const std::size_t directory = number(4, 4);
  HeaderSize size;
  for (std::size_t entry = 0; entry < number(directory, 2); ++entry) {
    const std::size_t at = directory + 2 + 12 * entry;
    const std::uint64_t value = number(at + 8, number(at + 2, 2) == 3 ? 2 : 4);
    if (number(at, 2) == 256) size.width = value;
    if (number(at, 2) == 257) size.height = value;
  }
  return size.width > 0 && size.height > 0 ? std::optional(size) : std::nullopt;
}

std::optional<HeaderSize> webp_size(const HeaderBytes& bytes) {
  if (bytes.starts_with("VP8X", 12)) return HeaderSize{bytes.little(24, 3) + 1, bytes.little(27, 3) + 1};
  if (bytes.starts_with("VP8L", 12)) {
    const std::uint64_t packed = bytes.little(21, 4);
    return HeaderSize{(packed & 0x3FFF) + 1, (packed >> 14 & 0x3FFF) + 1};
  }
  return HeaderSize{bytes.little(26, 2) & 0x3FFF, bytes.little(28, 2) & 0x3FFF};
}

std::uint64_t magnitude(std::uint64_t signed_32) { return signed_32 >> 31 ? (1ULL << 32) - signed_32 : signed_32; }

}  // namespace

std::optional<HeaderSize> image_header_size(std::span<const unsigned char> data) {
  const HeaderBytes bytes(data);
  constexpr std::size_t shortest = 8;
  if (bytes.size() < shortest) return std::nullopt;
  if (bytes.starts_with("\x89PNG")) return HeaderSize{bytes.big(16, 4), bytes.big(20, 4)};
  if (bytes.starts_with("\xFF\xD8\xFF")) return jpeg_size(bytes);
  if (bytes.starts_with("BM")) return HeaderSize{magnitude(bytes.little(18, 4)), magnitude(bytes.little(22, 4))};
  if (bytes.byte(0) == 'P' && bytes.byte(1) >= '1' && bytes.byte(1) <= '6') return pnm_size(bytes.view());
  if (bytes.starts_with("II*") || bytes.starts_with(std::string_view("MM\0*", 4))) return tiff_size(bytes);
  if (bytes.starts_with("RIFF") && bytes.starts_with("WEBP", 8)) return webp_size(bytes);
  return std::nullopt;
}

std::string why_too_large(std::span<const unsigned char> bytes) {
  const auto size = image_header_size(bytes);
  if (!size || size->width == 0 || size->height <= largest_image_pixels / size->width) return "";
  return fmt::format("claims {}x{} pixels, more than {} million", size->width, size->height,
                     largest_image_pixels / 1'000'000);
}

}  // namespace rastro
