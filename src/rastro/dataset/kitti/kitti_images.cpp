// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/kitti/kitti_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "rastro/base/text.h"
#include "rastro/dataset/folder.h"

namespace rastro {

std::int64_t file_number(const std::string& name) {
  const auto number = parse_int64(std::filesystem::path(name).stem().string());
  return number && *number >= 0 ? *number : -1;
}

std::vector<std::int64_t> rows_of_images(const std::vector<std::string>& names, std::size_t row_count) {
  std::vector<std::int64_t> rows;
  for (const auto& name : names) rows.push_back(file_number(name));
  const auto limit = static_cast<std::int64_t>(row_count);
  if (std::all_of(rows.begin(), rows.end(), [&](auto row) { return row >= 0 && row < limit; })) return rows;
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = k < row_count ? static_cast<std::int64_t>(k) : -1;
  return rows;
}

std::string kitti_right_of(const std::string& camera) {
  if (camera.empty()) return "";
  std::string right = camera;
  if (right.back() != '0' && right.back() != '2') return "";
  ++right.back();
  return right;
}

std::vector<RecordedFrame> kitti_frames(const std::filesystem::path& folder, const std::filesystem::path& right_folder,
                                        const std::vector<std::string>& names) {
  const auto right_names = right_folder.empty() ? std::vector<std::string>() : image_names(right_folder);
  // Without the ending: the two may be packed differently, as PNG and JPEG.
  std::map<std::string, std::string> right_of_stem;
  for (const auto& name : right_names) right_of_stem.emplace(std::filesystem::path(name).stem().string(), name);
  std::vector<RecordedFrame> frames;
  for (const auto& name : names) {
    const auto found = right_of_stem.find(std::filesystem::path(name).stem().string());
    const std::string right = found != right_of_stem.end() ? (right_folder / found->second).string() : "";
    frames.push_back({0, (folder / name).string(), right, "", 0});
  }
  return frames;
}

void describe_right(Recording& recording, const std::string& right, const std::filesystem::path& right_folder) {
  const auto pairs =
      std::count_if(recording.frames.begin(), recording.frames.end(), [](const auto& f) { return !f.right.empty(); });
  recording.info.has_right = pairs > 0;
  const bool has_images = pairs > 0 || (!right.empty() && !image_names(right_folder).empty());
  if (has_images && pairs < static_cast<std::int64_t>(recording.frames.size())) {
    recording.info.warnings.push_back(
        fmt::format("{} of {} frames have an image in {}", pairs, recording.frames.size(), right));
  }
}

}  // namespace rastro
