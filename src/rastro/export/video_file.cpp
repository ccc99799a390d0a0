// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/video_file.h"

#include "rastro/base/error.h"

#if RASTRO_WITH_VIDEO
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>

namespace rastro::detail {

class VideoFile::Writer {
 public:
  explicit Writer(std::filesystem::path path) : path_(std::move(path)) {
    if (path_.extension() != ".avi" && path_.extension() != ".mp4") {
      throw Error("not a video file name", path_.string(), "end the name with .avi or .mp4");
    }
    const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
    std::error_code ignored;
    if (!std::filesystem::is_directory(folder, ignored)) {
      throw Error("the folder of the video does not exist", folder.string(), "create it first");
    }
  }

  void write(const cv::Mat& image, double rate_hz) {
    if (!writer_.isOpened()) start(image, rate_hz);
    if (image.size() == size_) return writer_.write(image);
    cv::Mat padded;
    cv::copyMakeBorder(image, padded, 0, std::max(0, size_.height - image.rows), 0,
                       std::max(0, size_.width - image.cols), cv::BORDER_CONSTANT);
    writer_.write(padded(cv::Rect({0, 0}, size_)));
  }

  void finish() { writer_.release(); }

 private:
  void start(const cv::Mat& image, double rate_hz) {
    const bool avi = path_.extension() == ".avi";
    const int code = avi ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G') : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
    // MPEG-4 wants even sizes.
    size_ = {image.cols + image.cols % 2, image.rows + image.rows % 2};
    writer_.open(path_.string(), avi ? cv::CAP_OPENCV_MJPEG : cv::CAP_ANY, code, rate_hz, size_);
    if (!writer_.isOpened()) {
      throw Error("the video cannot be written", path_.string(), "check the permissions, or use a name ending in .avi");
    }
  }

  std::filesystem::path path_;
  cv::VideoWriter writer_;
  cv::Size size_;
};

VideoFile::VideoFile(const std::filesystem::path& path) : writer_(std::make_unique<Writer>(path)) {}
void VideoFile::write(const cv::Mat& image, double rate_hz) { writer_->write(image, rate_hz); }
void VideoFile::finish() { writer_->finish(); }

#else
namespace rastro::detail {

class VideoFile::Writer {};

VideoFile::VideoFile(const std::filesystem::path& path) {
  throw Error("this rastro was built without video files", path.string(),
              "write images instead, or build with -DRASTRO_WITH_VIDEO=ON");
}
void VideoFile::write(const cv::Mat&, double) {}
void VideoFile::finish() {}
#endif

VideoFile::~VideoFile() = default;

}  // namespace rastro::detail
