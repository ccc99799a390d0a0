// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/recording_files.h"

#include <opencv2/imgcodecs.hpp>

#include "rastro/base/error.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_to_write(const fs::path& file) {
  throw Error("the file cannot be written", file.string(), "check the folder's permissions and the free space");
}

/// What lies behind a link is not in the folder and stays.
void remove_former(const fs::path& folder, const fs::path& part) {
  std::error_code error;
  const fs::path there = fs::canonical((folder / part).parent_path(), error);
  if (error || there != (fs::canonical(folder, error) / part).parent_path()) return;
  fs::remove_all(folder / part, error);
  if (error)
    throw Error("the former recording cannot be removed (" + error.message() + ")", (folder / part).string(),
                "choose another --out");
}

}  // namespace

TextFile::TextFile(const fs::path& file, const std::string& head) : file_(file), stream_(file, std::ios::binary) {
  write(head);
}

void TextFile::write(const std::string& text) {
  stream_ << text << std::flush;
  if (!stream_) fail_to_write(file_);
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error("the folder cannot be made (" + error.message() + ")", folder.string(), "choose another --out");
}

FolderLock claim_folder(const fs::path& folder, bool force, const std::vector<fs::path>& parts) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    throw Error("this is not a folder", folder.string(), "choose another --out");
  make_folder(folder);
  FolderLock lock(folder);
  if (!force && !fs::is_empty(folder, error))
    throw Error("the folder is not empty", folder.string(), "choose another --out or use --force");
  if (force)
    for (const fs::path& part : parts) remove_former(folder, part);
  return lock;
}

std::uintmax_t write_png(const fs::path& file, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  // Without a level OpenCV uses the fastest one with row differences, which suits both images and smooth depth.
  if (!cv::imencode(".png", image, bytes)) fail_to_write(file);
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  stream.flush();
  if (!stream) fail_to_write(file);
  return bytes.size();
}

cv::Mat gray_image(const GrayImage& gray) {
  return {gray.height(), gray.width(), CV_8U, const_cast<std::uint8_t*>(gray.row(0)),
          static_cast<std::size_t>(gray.stride())};
}

}  // namespace rastro
