// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace rastro {

/// Bytes of the JPEG file at the start of `bytes`, up to its end marker; nullopt: it is not whole yet. 0: it is no JPEG
/// file, or damaged.
std::optional<std::size_t> jpeg_length(std::span<const unsigned char> bytes);

/// Takes a stream of JPEG files one after the other (MJPEG) in pieces of any length and gives them one by one. Bytes
/// between them, and files damaged in their structure, are skipped.
class JpegStream {
 public:
  void feed(std::span<const unsigned char> bytes) { buffer_.insert(buffer_.end(), bytes.begin(), bytes.end()); }
  /// The next file, valid until the next call; nullopt: more bytes are needed.
  std::optional<std::span<const unsigned char>> next();
  /// Bytes that wait.
  std::size_t size() const { return buffer_.size() - begin_; }

 private:
  std::vector<unsigned char> buffer_;
  std::size_t begin_ = 0;
};

}  // namespace rastro
