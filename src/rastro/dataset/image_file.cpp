// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/base/library_output.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/mat_conversion.h"
#include "rastro/image/image_header.h"

namespace rastro {
namespace {

constexpr std::array<unsigned char, 8> png_signature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

std::span<const unsigned char> as_bytes(const std::string& text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

std::uint32_t big_endian(std::span<const unsigned char> bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 | std::uint32_t{bytes[at + 2]} << 8 |
         bytes[at + 3];
}

bool is_png(std::span<const unsigned char> bytes) {
  return bytes.size() >= png_signature.size() && std::equal(png_signature.begin(), png_signature.end(), bytes.begin());
}

bool is_jpeg(std::span<const unsigned char> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

/// Walks the chunks (length, type, data, checksum) up to IEND.
bool png_is_whole(std::span<const unsigned char> bytes) {
  for (std::size_t at = png_signature.size(); at + 12 <= bytes.size();) {
    const std::size_t length = big_endian(bytes, at);
    if (length > bytes.size() - at - 12) return false;
    if (std::memcmp(bytes.data() + at + 4, "IEND", 4) == 0) return true;
    at += length + 12;
  }
  return false;
}

/// Position after the coded data that starts at `at`: of the next marker that is neither stuffing nor a restart.
std::size_t after_scan(std::span<const unsigned char> bytes, std::size_t at) {
  for (; at + 1 < bytes.size(); ++at) {
    const auto next = bytes[at + 1];
    if (bytes[at] == 0xFF && next != 0x00 && next != 0xFF && (next < 0xD0 || next > 0xD7)) return at;
  }
  return bytes.size();
}

/// Walks the segments up to the end-of-image marker.
bool jpeg_is_whole(std::span<const unsigned char> bytes) {
  for (std::size_t at = 2; at + 1 < bytes.size();) {
    if (bytes[at] != 0xFF) return false;
    const auto marker = bytes[at + 1];
    if (marker == 0xD9) return true;
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    if (at + 3 >= bytes.size()) return false;
    const std::size_t length = std::size_t{bytes[at + 2]} << 8 | bytes[at + 3];
    at += 2 + length;
    if (marker == 0xDA) at = after_scan(bytes, at);
  }
  return false;
}

/// What the decoder complains of is said once: a recording may have it in every image.
void warn_once(const std::string& path, const std::string& complaint) {
  static std::atomic<bool> warned = false;
  if (complaint.empty() || warned.exchange(true)) return;
  log_warning(fmt::format("{}: the image may be damaged: {}; further ones are not named", path,
                          one_line(trim(complaint.substr(0, complaint.find('\n'))))));
}

cv::Mat decode(const std::string& path) {
  const std::string bytes = read_text_file(path);
  if (const auto reason = why_incomplete(as_bytes(bytes)); !reason.empty()) throw Error(reason, path, "");
  if (const auto reason = why_too_large(as_bytes(bytes)); !reason.empty())
    throw Error(reason, path, "scale the images down");
  cv::Mat mat;
  const LibraryOutput output;
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    mat = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& exception) {
    throw Error("cannot be decoded as an image (" + exception.err + ")", path, "");
  }
  if (mat.empty()) throw Error("cannot be decoded as an image", path, "it is damaged or of another kind");
  warn_once(path, output.text());
  return mat;
}

}  // namespace

DecodedImage read_image(const std::string& path, bool want_color) {
  const cv::Mat mat = decode(path);
  DecodedImage image;
  const auto reason = convert(mat, want_color, image);
  if (!reason.empty()) throw Error(reason, path, "");
  return image;
}

Image<std::uint16_t> read_raw_depth(const std::string& path) {
  const cv::Mat mat = decode(path);
  if (mat.type() != CV_16UC1) {
    throw Error(
        fmt::format("a depth image has one channel of 16 bit, this has {} of {}", mat.channels(), 8 * mat.elemSize1()),
        path, mat.channels() == 3 ? "are the color and the depth images exchanged?" : "");
  }
  Image<std::uint16_t> raw(mat.cols, mat.rows);
  for (int y = 0; y < raw.height(); ++y) std::memcpy(raw.row(y), mat.ptr(y), 2 * static_cast<std::size_t>(raw.width()));
  return raw;
}

DepthImage depth_in_meters(const Image<std::uint16_t>& raw, double units_per_meter, double offset_m) {
  DepthImage depth(raw.width(), raw.height());
  const double scale = 1.0 / units_per_meter;
  for (int y = 0; y < raw.height(); ++y) {
    const std::uint16_t* from = raw.row(y);
    float* to = depth.row(y);
    for (int x = 0; x < raw.width(); ++x)
      to[x] = from[x] == 65535 || from[x] == 0 ? 0.0f : std::max(0.0f, static_cast<float>(from[x] * scale + offset_m));
  }
  return depth;
}

std::string why_incomplete(std::span<const unsigned char> bytes) {
  if (is_png(bytes) && !png_is_whole(bytes)) return "the PNG is cut short (no IEND at its end)";
  if (is_jpeg(bytes) && !jpeg_is_whole(bytes)) return "the JPEG is cut short (no end-of-image marker)";
  return "";
}

std::optional<ImageSize> image_size(const std::string& path) {
  try {
    const std::string bytes = read_text_file(path);
    if (is_png(as_bytes(bytes)) && bytes.size() >= 24) {
      return ImageSize{static_cast<int>(big_endian(as_bytes(bytes), 16)),
                       static_cast<int>(big_endian(as_bytes(bytes), 20))};
    }
    const auto image = read_image(path);
    return ImageSize{image.gray.width(), image.gray.height()};
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace rastro
