// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/packed_depth.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/library_output.h"
#include "rastro/image/image_header.h"

namespace rastro {
namespace {

constexpr std::array<std::uint8_t, 4> magic = {'R', 'D', 'Z', '1'};
constexpr std::size_t header_bytes = magic.size() + 2 * sizeof(std::uint32_t);
constexpr std::size_t most_bytes_of_pixel = 3;
/// The fastest of zstd's usual levels: higher ones save a tenth of the bytes for three times the time.
constexpr int compression_level = 1;

/// 0 where there is no depth that can be stored.
std::uint16_t units_of(float depth_m) {
  const double units = static_cast<double>(depth_m) * packed_depth_units_per_meter;
  if (!(units < 65535.5)) return 0;
  const double half_more = std::max(0.0, units) + 0.5;  // std::lround would be a call for each pixel
  return static_cast<std::uint16_t>(static_cast<std::int32_t>(half_more));
}

float depth_of(std::uint16_t units) {
  return static_cast<float>(static_cast<double>(units) / packed_depth_units_per_meter);
}

/// 0 for no depth, else one more than the zigzag number of the difference: of small magnitude, small.
std::uint32_t code_of(int difference) {
  return ((static_cast<std::uint32_t>(difference) << 1) ^ static_cast<std::uint32_t>(difference >> 31)) + 1;
}

int difference_of(std::uint32_t code) {
  const std::uint32_t zigzag = code - 1;
  return static_cast<int>(zigzag >> 1) ^ -static_cast<int>(zigzag & 1);
}

/// Seven bits a byte, the lowest first; the highest bit says that more follow.
std::uint8_t* put_code(std::uint32_t code, std::uint8_t* to) {
  for (; code >= 0x80; code >>= 7) *to++ = static_cast<std::uint8_t>(code | 0x80);
  *to++ = static_cast<std::uint8_t>(code);
  return to;
}

std::uint8_t* put_row(const std::vector<std::uint16_t>& row, std::uint8_t* to) {
  int last = 0;
  for (const std::uint16_t units : row) {
    to = put_code(units == 0 ? 0 : code_of(units - last), to);
    if (units != 0) last = units;
  }
  return to;
}

std::vector<std::uint8_t> codes_of(const DepthImage& depth) {
  const auto width = static_cast<std::size_t>(depth.width()), height = static_cast<std::size_t>(depth.height());
  std::vector<std::uint8_t> codes(width * height * most_bytes_of_pixel);
  std::uint8_t* end = codes.data();
  std::vector<std::uint16_t> row(width);
  for (int y = 0; y < depth.height(); ++y) {
    std::transform(depth.row(y), depth.row(y) + width, row.begin(), units_of);
    end = put_row(row, end);
  }
  codes.resize(static_cast<std::size_t>(end - codes.data()));
  return codes;
}

/// Reads codes; says so where they end too early or are none.
class CodeReader {
 public:
  explicit CodeReader(std::span<const std::uint8_t> bytes) : next_(bytes.data()), end_(next_ + bytes.size()) {}

  std::uint32_t code() {
    if (next_ != end_ && *next_ < 0x80) return *next_++;
    std::uint32_t code = 0;
    for (int shift = 0; shift < 7 * static_cast<int>(most_bytes_of_pixel); shift += 7) {
      if (next_ == end_) break;
      const std::uint8_t byte = *next_++;
      code |= static_cast<std::uint32_t>(byte & 0x7F) << shift;
      if (byte < 0x80) return code;
    }
    good_ = false;
    return 0;
  }

  void refuse() { good_ = false; }
  bool is_whole() const { return good_ && next_ == end_; }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
  bool good_ = true;
};

void read_row(CodeReader& reader, std::vector<std::uint16_t>& row) {
  int last = 0;
  for (std::uint16_t& units : row) {
    const std::uint32_t code = reader.code();
    units = 0;
    if (code == 0) continue;
    last += difference_of(code);
    if (last <= 0 || last > 65535) return reader.refuse();
    units = static_cast<std::uint16_t>(last);
  }
}

/// Of a header that claims no more pixels than are decoded; each has a byte at least, and three at most.
std::optional<DepthImage> unpacked(std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> packed) {
  if (width == 0 || height == 0 || height > largest_image_pixels / width) return std::nullopt;
  const std::size_t pixels = std::size_t{width} * height;
  const unsigned long long claimed = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (claimed < pixels || claimed > most_bytes_of_pixel * pixels) return std::nullopt;
  std::vector<std::uint8_t> codes(static_cast<std::size_t>(claimed));
  if (ZSTD_decompress(codes.data(), codes.size(), packed.data(), packed.size()) != codes.size()) return std::nullopt;
  DepthImage depth(static_cast<int>(width), static_cast<int>(height));
  CodeReader reader(codes);
  std::vector<std::uint16_t> row(width);
  for (int y = 0; y < depth.height(); ++y) {
    read_row(reader, row);
    std::transform(row.begin(), row.end(), depth.row(y), depth_of);
  }
  if (!reader.is_whole()) return std::nullopt;
  return depth;
}

std::optional<DepthImage> decoded_png(std::span<const std::uint8_t> bytes) {
  if (bytes.empty() || !why_too_large(bytes).empty()) return std::nullopt;
  const LibraryOutput output;
  cv::Mat units;
  try {
    units = cv::imdecode(std::vector<std::uint8_t>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (units.empty() || units.type() != CV_16UC1) return std::nullopt;
  DepthImage depth(units.cols, units.rows);
  for (int y = 0; y < units.rows; ++y) {
    const auto* row = units.ptr<std::uint16_t>(y);
    std::transform(row, row + units.cols, depth.row(y), depth_of);
  }
  return depth;
}

}  // namespace

std::vector<std::uint8_t> pack_depth(const DepthImage& depth) {
  if (depth.empty()) return {};
  const std::vector<std::uint8_t> codes = codes_of(depth);
  std::vector<std::uint8_t> bytes(header_bytes + ZSTD_compressBound(codes.size()));
  const std::uint32_t size[] = {static_cast<std::uint32_t>(depth.width()), static_cast<std::uint32_t>(depth.height())};
  std::copy(magic.begin(), magic.end(), bytes.begin());
  std::memcpy(bytes.data() + magic.size(), size, sizeof size);
  const std::size_t length = ZSTD_compress(bytes.data() + header_bytes, bytes.size() - header_bytes, codes.data(),
                                           codes.size(), compression_level);
  bytes.resize(header_bytes + length);
  bytes.shrink_to_fit();
  return bytes;
}

std::optional<DepthImage> unpack_depth(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < header_bytes || !std::equal(magic.begin(), magic.end(), bytes.begin())) return decoded_png(bytes);
  std::uint32_t size[2];
  std::memcpy(size, bytes.data() + magic.size(), sizeof size);
  return unpacked(size[0], size[1], bytes.subspan(header_bytes));
}

DepthImage rounded_as_packed(const DepthImage& depth) {
  DepthImage rounded(depth.width(), depth.height());
  for (int y = 0; y < depth.height(); ++y)
    std::transform(depth.row(y), depth.row(y) + depth.width(), rounded.row(y),
                   [](float depth_m) { return depth_of(units_of(depth_m)); });
  return rounded;
}

}  // namespace rastro
