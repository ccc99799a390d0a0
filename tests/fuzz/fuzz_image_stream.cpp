// SPDX-License-Identifier: Apache-2.0
// Y4M and MJPEG from a pipe: whatever the bytes, and in whatever pieces they come, the readers give images of the size
// that the header tells, or throw rastro::Error, and they never wait for more than there is room for.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/dataset/live/jpeg_stream.h"
#include "rastro/dataset/live/y4m.h"

namespace {

/// The first byte is the length of the pieces.
template <typename Stream, typename Check>
void feed(std::span<const unsigned char> bytes, std::size_t piece, const Check& check) {
  Stream stream;
  try {
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
      stream.feed(bytes.subspan(at, std::min(piece, bytes.size() - at)));
      while (const auto image = stream.next()) check(stream, *image);
    }
  } catch (const rastro::Error& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t piece = std::size_t{1} + data[0];
  const std::span<const unsigned char> bytes(data + 1, size - 1);
  feed<rastro::Y4mStream>(bytes, piece, [](const rastro::Y4mStream& stream, std::span<const unsigned char> planes) {
    if (planes.size() != stream.header()->frame_bytes()) __builtin_trap();
  });
  feed<rastro::JpegStream>(bytes, piece, [](const rastro::JpegStream&, std::span<const unsigned char> file) {
    if (rastro::jpeg_length(file) != file.size()) __builtin_trap();
  });
  return 0;
}
