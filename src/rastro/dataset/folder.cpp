// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/folder.h"

#include <fnmatch.h>

#include <algorithm>
#include <cctype>

#include "rastro/base/error.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view take_number(std::string_view text, std::size_t& position) {
  while (position < text.size() && text[position] == '0') ++position;
  const auto begin = position;
  while (position < text.size() && is_digit(text[position])) ++position;
  return text.substr(begin, position - begin);
}

bool has_ending(const fs::path& path, std::initializer_list<std::string_view> endings) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

template <typename Wanted>
std::vector<std::string> names_in(const fs::path& folder, Wanted wanted) {
  if (!is_folder(folder)) return {};
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  if (error) throw Error("cannot be listed (" + error.message() + ")", folder.string(), "");
  std::vector<std::string> names;
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with('.') && wanted(entry->path())) names.push_back(name);
  }
  // An error in the middle ends the loop.
  if (error) throw Error("cannot be listed (" + error.message() + ")", folder.string(), "");
  std::sort(names.begin(), names.end(), natural_less);
  return names;
}

}  // namespace

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

void require_folder(const fs::path& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw Error("no such file or folder", path.string(), "check the path");
  if (error) throw Error("cannot be read (" + error.message() + ")", path.string(), "");
  if (status.type() != fs::file_type::directory) throw Error("is not a folder", path.string(), "");
  const fs::directory_iterator listing(path, error);
  if (error == std::errc::permission_denied) throw Error("no permission to list the folder", path.string(), "");
  if (error) throw Error("cannot be listed (" + error.message() + ")", path.string(), "");
}

bool natural_less(std::string_view a, std::string_view b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto left = take_number(a, i), right = take_number(b, j);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;  // "01" and "1" are equal as numbers; the order must still be total.
}

bool has_image_ending(const fs::path& path) {
  return has_ending(path, {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".pnm", ".bmp", ".tif", ".tiff", ".webp"});
}

bool has_video_ending(const fs::path& path) {
  return has_ending(path, {".mp4", ".avi", ".mkv", ".mov", ".m4v", ".webm", ".mpg", ".mpeg", ".wmv", ".ogv", ".mts"});
}

std::vector<std::string> image_names(const fs::path& folder) {
  return names_in(folder, [](const fs::path& path) { return has_image_ending(path) && !is_folder(path); });
}

std::vector<std::string> folder_names(const fs::path& folder) {
  return names_in(folder, [](const fs::path& path) { return is_folder(path); });
}

bool matches_pattern(std::string_view name, std::string_view pattern) {
  return fnmatch(std::string(pattern).c_str(), std::string(name).c_str(), 0) == 0;
}

}  // namespace rastro
