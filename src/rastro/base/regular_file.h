// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace rastro {

/// What is read into memory as a whole; larger files are refused before they are read.
constexpr std::uintmax_t largest_text_file_bytes = std::uintmax_t{256} << 20;  ///< Calibrations, lists, images.
constexpr std::uintmax_t largest_whole_file_bytes = std::uintmax_t{4} << 30;   ///< Clouds, meshes, tables.

/// Error, naming the file and what it is, unless `path` is a regular file (or a link to one) of at most
/// `largest_bytes`: opening a FIFO waits for a writer that may never come, and a device has no end.
void require_regular_file(const std::filesystem::path& path, std::uintmax_t largest_bytes);

}  // namespace rastro
