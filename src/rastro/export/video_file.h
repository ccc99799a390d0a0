// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

namespace rastro::detail {

/// Motion JPEG for .avi, MPEG-4 for .mp4. Error for another extension, where the file cannot be made, and where rastro
/// was built without video.
class VideoFile {
 public:
  explicit VideoFile(const std::filesystem::path& path);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  /// At the rate of the first image that is written; later ones are cut or padded to its size.
  void write(const cv::Mat& image, double rate_hz);
  void finish();

 private:
  class Writer;
  std::unique_ptr<Writer> writer_;
};

}  // namespace rastro::detail
