// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace rastro {

/// Error where `out` exists and must not be overwritten, or where the system cannot even look (a name that is too long,
/// a folder that may not be entered).
void refuse_existing(const std::filesystem::path& out, bool overwrite);

/// A folder for results, made and tried before the work whose results go into it, so that an hour of it is not lost.
class OutputFolder {
 public:
  /// Error where it cannot be made, is a file, or cannot be written to.
  explicit OutputFolder(std::filesystem::path folder);
  /// Removes it again if it was made here and nothing was written.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

 private:
  std::filesystem::path folder_;
  bool made_ = false;
};

}  // namespace rastro
