// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>

#include "rastro/image/image.h"

namespace rastro {

// What the writers of recordings share. All throw Error, naming the file, where something cannot be written.

/// A text file that is on the disk after every write.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& file, const std::string& head = "");
  void write(const std::string& text);

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
};

void make_folder(const std::filesystem::path& folder);
/// Error where the folder is a file, or holds something and `force` is not set.
void check_folder(const std::filesystem::path& folder, bool force);
/// Returns the size of the file.
std::uintmax_t write_png(const std::filesystem::path& file, const cv::Mat& picture);
/// Shares the pixels of `grey`, which are not to be written to.
cv::Mat grey_picture(const GreyImage& grey);

}  // namespace rastro
