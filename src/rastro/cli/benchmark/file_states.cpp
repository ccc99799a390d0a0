// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/file_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <system_error>

#include "rastro/cli/benchmark/benchmark_plan.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr int deepest = 2;  ///< Folders below a recording with files that say what it is, as mav0/cam0.

/// Of regular files together.
struct FilesSeen {
  std::int64_t files = 0;
  std::uintmax_t bytes = 0;
  fs::file_time_type::duration newest{0};

  void add(const fs::path& path) {
    std::error_code no_size, no_time;
    const std::uintmax_t size = fs::file_size(path, no_size);
    const auto time = fs::last_write_time(path, no_time);
    if (no_size || no_time) return;
    newest = files == 0 ? time.time_since_epoch() : std::max(newest, time.time_since_epoch());
    ++files, bytes += size;
  }
};

/// Results that a person keeps with the recording are not of it.
bool is_of_results(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "about.json", ignored) ||
         (fs::is_directory(folder / "results", ignored) && fs::is_directory(folder / "runs", ignored));
}

FilesSeen files_in(const fs::path& folder) {
  FilesSeen seen;
  std::error_code error;
  fs::recursive_directory_iterator each(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && each != fs::recursive_directory_iterator(); each.increment(error)) {
    std::error_code ignored;
    if (each->is_regular_file(ignored))
      seen.add(each->path());
    else if (each->is_directory(ignored) && (each.depth() >= deepest || is_of_results(each->path())))
      each.disable_recursion_pending();
  }
  return seen;
}

FilesSeen seen_at(const fs::path& path) {
  std::error_code ignored;
  FilesSeen seen;
  if (fs::is_regular_file(path, ignored))
    seen.add(path);
  else if (path.is_absolute() && fs::is_directory(path, ignored))
    seen = files_in(path);
  return seen;
}

}  // namespace

const std::string& FileStates::of_path(const fs::path& path) {
  const auto [known, is_new] = known_.emplace(path.string(), "");
  if (!is_new) return known->second;
  const FilesSeen seen = seen_at(path);
  if (seen.files > 0)
    known->second =
        fmt::format("; {}: {} files, {} bytes, {}", path.string(), seen.files, seen.bytes, seen.newest.count());
  return known->second;
}

std::string FileStates::of(const std::vector<std::string>& words) {
  std::string states;
  for (const std::string& word : words) {
    if (word.empty() || word.starts_with(below_out)) continue;
    states += of_path(word);
    if (const std::size_t equals = word.find('='); equals != std::string::npos && equals + 1 < word.size())
      states += of_path(word.substr(equals + 1));
  }
  return states;
}

}  // namespace rastro::cli
