// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

namespace rastro {

/// A path in a temporary folder of this process, which is removed at its end: ctest runs tests of one program in
/// parallel, so they would share fixed names below /tmp. Leftovers of an earlier test are removed; only the parent
/// folder is created.
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

/// The same, created as an empty folder.
inline std::filesystem::path scratch_folder(const std::string& name) {
  std::filesystem::path path = scratch_path(name);
  std::filesystem::create_directories(path);
  return path;
}

}  // namespace rastro
