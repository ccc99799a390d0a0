// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

struct DecodedImage {
  GrayImage gray;
  ColorImage color;  ///< Only when asked for; a gray file gives three equal channels.
};

struct ImageSize {
  int width = 0;
  int height = 0;
  bool operator==(const ImageSize&) const = default;
};

/// Reads and decodes one image: 8-bit gray as it is, color converted to gray, 16 bit scaled to 8. Error, naming the
/// file, where it is missing, may not be read, is empty, cut short, damaged or no image.
DecodedImage read_image(const std::string& path, bool want_color = false);

/// The numbers of a one-channel 16-bit image; errors as above, and for any other kind of image.
Image<std::uint16_t> read_raw_depth(const std::string& path);

/// Meters from raw numbers: raw / units_per_meter + offset_m; 0 and 65535 mean no measurement.
DepthImage depth_in_meters(const Image<std::uint16_t>& raw, double units_per_meter, double offset_m = 0.0);

/// Why the bytes of a PNG or JPEG file are not a whole file ("ends early ..."); empty when they are, or for other
/// kinds. Decoders hand out half-filled images without a word, so this is asked first.
std::string why_incomplete(std::span<const unsigned char> bytes);

/// Size without decoding where the kind allows (PNG); nullopt where the file cannot be read.
std::optional<ImageSize> image_size(const std::string& path);

}  // namespace rastro
