// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/masks.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/dataset/image_file.h"

namespace rastro::cli {
namespace {

bool is_image(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  constexpr const char* known[] = {".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff"};
  return std::find(std::begin(known), std::end(known), extension) != std::end(known);
}

bool is_black(GrayView image) {
  for (int y = 0; y < image.height; ++y)
    if (std::any_of(image.row(y), image.row(y) + image.width, [](std::uint8_t value) { return value != 0; }))
      return false;
  return true;
}

std::string stem_of(const std::string& name) { return std::filesystem::path(name).stem().string(); }

}  // namespace

Masks::Masks(const std::filesystem::path& path) : path_(path) {
  std::error_code code;
  is_folder_ = std::filesystem::is_directory(path, code);
  if (!is_folder_) {
    mask_ = read_image(path.string()).gray;
    if (is_black(mask_))
      log_warning(path.string() +
                  ": the mask is black everywhere, so there will be no features; make it white where they may be");
    return;
  }
  for (const auto& entry : std::filesystem::directory_iterator(path, code)) {
    if (is_image(entry.path())) files_.push_back(entry.path().string());
  }
  if (code) throw Error("the folder cannot be read (" + code.message() + ")", path.string(), "check --mask");
  if (files_.empty()) throw Error("no image in this folder", path.string(), "give one mask per frame, or one file");
  std::sort(files_.begin(), files_.end());
  for (std::size_t i = 0; i < files_.size(); ++i) number_of_stem_[stem_of(files_[i])] = i;
}

const std::string& Masks::file_of(const Frame& frame) {
  const auto named = number_of_stem_.find(stem_of(frame.name));
  if (!decided_) by_name_ = named != number_of_stem_.end();
  decided_ = true;
  if (by_name_) {
    if (named != number_of_stem_.end()) return files_[named->second];
    throw Error(fmt::format("no mask for frame '{}'", frame.name), path_.string(),
                "give every frame a mask of its name");
  }
  if (frame.index < static_cast<std::int64_t>(files_.size())) return files_[static_cast<std::size_t>(frame.index)];
  throw Error(fmt::format("{} masks, but none for frame {}", files_.size(), frame.index), path_.string(),
              "give one mask per frame, or one file for all");
}

GrayView Masks::mask_of(const Frame& frame) {
  const std::string file = is_folder_ ? file_of(frame) : path_.string();
  if (is_folder_) mask_ = read_image(file).gray;
  if (mask_.width() != frame.image.width() || mask_.height() != frame.image.height()) {
    throw Error(fmt::format("the mask is {}x{}, but the images are {}x{}", mask_.width(), mask_.height(),
                            frame.image.width(), frame.image.height()),
                file, "give a mask of the size of the images");
  }
  return mask_;
}

}  // namespace rastro::cli
