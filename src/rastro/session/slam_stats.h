// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// stats.csv of a SLAM run: one row per frame, one column for the time of each stage. A stage that first occurs during
/// the run (a loop closure) gets a column then, empty in earlier rows.
class SlamStats {
 public:
  explicit SlamStats(std::filesystem::path file) : file_(std::move(file)) {}
  void add(const SlamUpdate& update);

 private:
  void widen(std::size_t added_columns);
  std::string header() const;

  std::filesystem::path file_;
  std::vector<std::string> stages_;  ///< In the order of their columns.
  std::optional<AppendFile> rows_;
};

}  // namespace rastro
