// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/sensor/frame.h"

namespace rastro::cli {

/// The masks of --mask: one image for all frames, or a folder with one per frame. Zero (black) where nothing may be
/// detected. In a folder, masks belong to the frames by name (the extension may differ) where the first frame's name is
/// there, else by order: the n-th mask in the order of names is that of frame n.
class Masks {
 public:
  /// Error where there is nothing to read. Warns of a mask for all frames that is black everywhere.
  explicit Masks(const std::filesystem::path& path);
  /// Valid until the next call. Error where the frame has no mask, or one of another size.
  GrayView mask_of(const Frame& frame);

 private:
  const std::string& file_of(const Frame& frame);

  std::filesystem::path path_;
  bool is_folder_ = false;
  bool by_name_ = false;
  bool decided_ = false;
  std::vector<std::string> files_;
  std::map<std::string, std::size_t> number_of_stem_;
  GrayImage mask_;
};

}  // namespace rastro::cli
