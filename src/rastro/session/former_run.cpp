// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/former_run.h"

#include <system_error>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr const char* aside = "former_run";

}  // namespace

FormerRun::FormerRun(fs::path folder, std::vector<fs::path> files) : folder_(std::move(folder)) {
  std::error_code code;
  if (files.empty()) return;
  if (fs::is_directory(folder_ / aside, code) && !fs::exists(folder_ / "stats.csv", code)) {
    // The last run was killed before its first frame: what it set aside is still the former one.
    for (const fs::path& file : files) fs::remove(file, code);
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / aside, code))
      if (entry.is_regular_file(code)) files_.push_back(entry.path().lexically_relative(folder_ / aside));
    return;
  }
  fs::remove_all(folder_ / aside, code);
  for (const fs::path& file : files) {
    const fs::path target = folder_ / aside / file.lexically_relative(folder_);
    fs::create_directories(target.parent_path(), code);
    fs::rename(file, target, code);
    if (code) {
      bring_back();
      throw Error("cannot be replaced (" + code.message() + ")", file.string(), "choose another --out");
    }
    files_.push_back(file.lexically_relative(folder_));
  }
}

void FormerRun::remove() {
  std::error_code ignored;
  if (!files_.empty()) fs::remove_all(folder_ / aside, ignored);
  files_.clear();
}

void FormerRun::bring_back() {
  std::error_code ignored;
  for (const fs::path& file : files_) {
    fs::create_directories((folder_ / file).parent_path(), ignored);
    fs::rename(folder_ / aside / file, folder_ / file, ignored);
  }
  remove();
}

}  // namespace rastro
