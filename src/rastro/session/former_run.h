// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace rastro {

/// Files of a former run that a new one replaces: set aside until the new one has a result, so that an input that turns
/// out to be unusable costs nothing. What a killed run leaves aside is in the folder `former_run`.
class FormerRun {
 public:
  /// Sets `files` aside, which lie in `folder`. Error where one cannot be moved.
  FormerRun(std::filesystem::path folder, std::vector<std::filesystem::path> files);
  FormerRun(const FormerRun&) = delete;
  FormerRun& operator=(const FormerRun&) = delete;

  bool is_aside() const { return !files_.empty(); }
  /// Removes them for good.
  void remove();
  void bring_back();

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;  ///< Relative to the folder.
};

}  // namespace rastro
