// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/slam_stats.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/memory.h"

namespace rastro {

void SlamStats::add(const SlamUpdate& update) {
  const std::size_t columns = stages_.size();
  for (const StageTime& time : update.times)
    if (std::find(stages_.begin(), stages_.end(), time.stage) == stages_.end()) stages_.emplace_back(time.stage);
  if (!rows_) {
    rows_.emplace(file_);
    rows_->append(header());
  } else if (stages_.size() > columns) {
    widen(stages_.size() - columns);
  }
  std::string row =
      fmt::format("{},{},{},{},{:.4f},{},{:.4f},{:.1f}", update.index, update.stamp, name_of(update.state),
                  name_of(update.reason), update.score, update.used, update.milliseconds, resident_memory_mb());
  for (const std::string& stage : stages_) {
    const auto is_it = [&](const StageTime& time) { return stage == time.stage; };
    const auto time = std::find_if(update.times.begin(), update.times.end(), is_it);
    row += time == update.times.end() ? "," : fmt::format(",{:.4f}", time->milliseconds);
  }
  rows_->append(row + "\n");
}

void SlamStats::widen(std::size_t added_columns) {
  const std::string former = read_whole_file(file_);
  std::string text = header();
  // The file is replaced atomically: a run killed at this point keeps its rows.
  for (std::size_t begin = former.find('\n') + 1; begin < former.size();) {
    const std::size_t end = std::min(former.find('\n', begin), former.size());
    text += former.substr(begin, end - begin) + std::string(added_columns, ',') + "\n";
    begin = end + 1;
  }
  write_whole_file(file_, text);
  rows_.emplace(file_, AppendFile::Former::kept);
}

std::string SlamStats::header() const {
  std::string line = "frame,stamp_ns,state,reason,score,used,total_ms,resident_mb";
  for (const std::string& stage : stages_) line += "," + stage + "_ms";
  return line + "\n";
}

}  // namespace rastro
