// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace rastro {

/// Path of recorded data with this name: below RASTRO_DATA, or below ../shared/data beside the sources. An empty name
/// gives the folder itself.
inline std::filesystem::path recorded_data_path(const std::filesystem::path& name) {
  const char* set = std::getenv("RASTRO_DATA");
  const char* sources = std::getenv("RASTRO_SOURCE_DIR");
  const std::filesystem::path root =
      set && *set ? std::filesystem::path(set) : std::filesystem::path(sources ? sources : ".") / "../shared/data";
  return name.empty() ? root : root / name;
}

/// The same if it exists; otherwise a test skips itself: GTEST_SKIP() << no_recorded_data(name).
inline std::optional<std::filesystem::path> recorded_data(const std::filesystem::path& name) {
  const auto path = recorded_data_path(name);
  return std::filesystem::exists(path) ? std::optional(path) : std::nullopt;
}

inline std::string no_recorded_data(const std::filesystem::path& name) {
  return "no recorded data at " + recorded_data_path(name).string() + " (set RASTRO_DATA)";
}

}  // namespace rastro
