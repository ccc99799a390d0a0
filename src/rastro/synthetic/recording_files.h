// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "rastro/base/folder_lock.h"
#include "rastro/image/image.h"

namespace rastro {

// Shared by the writers of recordings. All throw Error, naming the file, if something cannot be written.

/// A text file that is flushed to disk after every write.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& file, const std::string& head = "");
  void write(const std::string& text);

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
};

void make_folder(const std::filesystem::path& folder);
/// Makes the folder and keeps other runs from writing to it while the lock lives. Throws Error if it is a file, is in
/// use by another run, or is not empty and `force` is not set. With it `parts`, files and folders within the folder,
/// are removed: what a former recording there has and the new one lacks would be taken for a part of the new one.
[[nodiscard]] FolderLock claim_folder(const std::filesystem::path& folder, bool force,
                                      const std::vector<std::filesystem::path>& parts = {});
/// Returns the size of the file.
std::uintmax_t write_png(const std::filesystem::path& file, const cv::Mat& image);
/// Shares the pixels of `gray`, which must not be written to.
cv::Mat gray_image(const GrayImage& gray);

}  // namespace rastro
