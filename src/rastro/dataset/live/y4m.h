// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

/// Of a YUV4MPEG2 stream, 8 bit a sample. https://wiki.multimedia.cx/index.php/YUV4MPEG2
struct Y4mHeader {
  int width = 0, height = 0;
  /// The chroma planes have 1 / these of the pixels in each direction; 0: there are none.
  int chroma_x = 2, chroma_y = 2;
  double rate_hz = 0.0;     ///< 0: not told.
  bool full_range = false;  ///< 0..255 rather than 16..235.

  std::size_t luma_bytes() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  std::size_t chroma_width() const;
  std::size_t chroma_height() const;
  std::size_t frame_bytes() const;  ///< Of the three planes.
};

/// "YUV4MPEG2 W640 H480 F30:1 C420jpeg", without the line's end. Error for anything that cannot be read: another depth
/// than 8 bit, interlacing, no size or one beyond 16384.
Y4mHeader parse_y4m_header(std::string_view line);

/// Takes a stream in pieces of any length and gives its images.
class Y4mStream {
 public:
  void feed(std::span<const unsigned char> bytes) { buffer_.insert(buffer_.end(), bytes.begin(), bytes.end()); }
  /// The planes of the next image, frame_bytes() long and valid until the next call; nullopt: more bytes are needed.
  /// Error for what is no Y4M; every later call then throws as well.
  std::optional<std::span<const unsigned char>> next();
  /// Known from the first image on.
  const std::optional<Y4mHeader>& header() const { return header_; }
  /// Bytes that wait.
  std::size_t size() const { return buffer_.size() - begin_; }

 private:
  std::optional<std::string_view> take_line(std::size_t most);
  void drop_used();

  std::vector<unsigned char> buffer_;
  std::size_t begin_ = 0;
  std::optional<Y4mHeader> header_;
  bool in_frame_ = false;
};

}  // namespace rastro
