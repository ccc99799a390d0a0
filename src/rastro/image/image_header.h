// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace rastro {

/// More pixels are not decoded: a file of a few kB may claim as many as fill any memory.
constexpr std::uint64_t largest_image_pixels = std::uint64_t{128} << 20;

struct HeaderSize {
  std::uint64_t width = 0, height = 0;
};

/// The size that the header of a PNG, JPEG, BMP, PNM, TIFF or WebP file claims; nullopt for other kinds and headers
/// that are cut short.
std::optional<HeaderSize> image_header_size(std::span<const unsigned char> bytes);

/// Why an image of this header is not decoded ("claims 20000x20000 pixels ..."); empty if it may be.
std::string why_too_large(std::span<const unsigned char> bytes);

}  // namespace rastro
