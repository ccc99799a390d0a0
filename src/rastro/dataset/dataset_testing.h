// SPDX-License-Identifier: Apache-2.0
// For tests: small recordings written into a folder that goes away with the test.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace rastro {

/// A folder of its own below the system's temporary one, removed at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string path(const std::string& name = "") const;
  /// Makes the folders above the file.
  void write(const std::string& name, const std::string& text) const;
  /// An image whose every pixel is `value`: 8-bit gray, or BGR with that blue, half of it green and no red.
  void write_gray(const std::string& name, int value, int width = 8, int height = 6) const;
  void write_color(const std::string& name, int value, int width = 8, int height = 6) const;
  void write_depth(const std::string& name, int raw, int width = 8, int height = 6) const;
  /// Keeps only the first bytes of a file.
  void truncate(const std::string& name, double share) const;

 private:
  std::filesystem::path path_;
};

// Small recordings; image k is gray value 10 + k, at k * 50 ms.
void write_euroc(const ScratchFolder& folder, int frames, int cameras = 1);
void write_tum(const ScratchFolder& folder, int frames);
void write_kitti(const ScratchFolder& folder, int frames, int pairs);
void write_kitti_raw(const ScratchFolder& folder, int frames);

/// A Matroska video (JPEG images, 8x6) with a frame at each of these milliseconds, of gray value 10, 20, 30, ... It
/// tells neither its length nor how many frames it has.
void write_matroska(const ScratchFolder& folder, const std::string& name, const std::vector<std::int64_t>& stamps_ms);

/// What `action` throws as rastro::Error; "" when it throws none.
std::string error_of(const std::function<void()>& action);

}  // namespace rastro
