// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace rastro {

/// Keeps other runs from writing to a folder, until it is destroyed or the program ends. It leaves no file behind. On a
/// file system without locks it does nothing.
class FolderLock {
 public:
  /// Error if another run has locked the folder. A folder that cannot be opened is left to whatever writes to it.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace rastro
