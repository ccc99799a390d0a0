// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

namespace rastro {

/// A path in a folder that only this process has and that goes with it: ctest runs tests of one program at once, so
/// fixed names below /tmp would be shared. What an earlier test left there is removed; nothing is made but the folder
/// above it.
inline std::filesystem::path scratch_path(const std::string& name) {
  struct Folder {
    std::filesystem::path path = std::filesystem::temp_directory_path() / ("rastro_test_" + std::to_string(::getpid()));
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  std::filesystem::remove_all(folder.path / name);
  std::filesystem::create_directories(folder.path);
  return folder.path / name;
}

/// The same as an empty folder.
inline std::filesystem::path scratch_folder(const std::string& name) {
  std::filesystem::path path = scratch_path(name);
  std::filesystem::create_directories(path);
  return path;
}

}  // namespace rastro
