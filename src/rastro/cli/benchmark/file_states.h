// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace rastro::cli {

/// What shows that files changed since a run read them: number, size and time, not their bytes, which are too many.
class FileStates {
 public:
  /// Of those words that are files, also behind a '=', or absolute paths of folders, a clause each; empty: none is one.
  /// Words that begin with below_out are made by the benchmark itself and left out.
  std::string of(const std::vector<std::string>& words);

 private:
  const std::string& of_path(const std::filesystem::path& path);

  std::map<std::string, std::string> known_;  ///< Many runs read the same.
};

}  // namespace rastro::cli
