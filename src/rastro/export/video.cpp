// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/video.h"

#include "rastro/base/error.h"

#if RASTRO_WITH_VIDEO
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>

#include "rastro/export/drawing.h"

namespace rastro {

/// The rate is known with the second frame, so the first one waits for it.
class TrackVideo::Writer {
 public:
  explicit Writer(std::filesystem::path path) : path_(std::move(path)) {
    if (path_.extension() != ".avi" && path_.extension() != ".mp4") {
      throw Error("not a video file name", path_.string(), "end the name with .avi or .mp4");
    }
    const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
    if (!std::filesystem::is_directory(folder)) {
      throw Error("the folder of the video does not exist", folder.string(), "create it first");
    }
  }

  void write(const TrackFrame& frame, GrayView image) {
    cv::Mat drawn = drawing::overlay(frame, image);
    if (writer_.isOpened()) {
      put(drawn);
    } else if (first_.empty()) {
      first_ = drawn;
      first_stamp_ = frame.stamp;
    } else {
      start(rate_between(first_stamp_, frame.stamp));
      put(drawn);
    }
  }

  void finish() {
    if (!first_.empty()) start(usual_rate_hz);  // a run of one frame
    writer_.release();
  }

 private:
  static constexpr double usual_rate_hz = 20.0;

  static double rate_between(TimeNs first, TimeNs second) {
    if (second <= first) return usual_rate_hz;
    return std::clamp(1.0 / to_seconds(second - first), 1.0, 120.0);
  }

  void start(double rate_hz) {
    const bool avi = path_.extension() == ".avi";
    const int code = avi ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G') : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
    // MPEG-4 wants even sizes.
    size_ = {first_.cols + first_.cols % 2, first_.rows + first_.rows % 2};
    writer_.open(path_.string(), avi ? cv::CAP_OPENCV_MJPEG : cv::CAP_ANY, code, rate_hz, size_);
    if (!writer_.isOpened()) {
      throw Error("the video cannot be written", path_.string(), "check the permissions, or use a name ending in .avi");
    }
    put(std::exchange(first_, cv::Mat()));
  }

  void put(const cv::Mat& image) {
    if (image.size() == size_) {
      writer_.write(image);
      return;
    }
    cv::Mat padded;
    cv::copyMakeBorder(image, padded, 0, std::max(0, size_.height - image.rows), 0,
                       std::max(0, size_.width - image.cols), cv::BORDER_CONSTANT);
    writer_.write(padded(cv::Rect({0, 0}, size_)));
  }

  std::filesystem::path path_;
  cv::VideoWriter writer_;
  cv::Size size_;
  cv::Mat first_;
  TimeNs first_stamp_ = 0;
};

TrackVideo::TrackVideo(const std::filesystem::path& path) : writer_(std::make_unique<Writer>(path)) {}
void TrackVideo::write(const TrackFrame& frame, GrayView image) { writer_->write(frame, image); }
void TrackVideo::finish() { writer_->finish(); }

#else
namespace rastro {

class TrackVideo::Writer {};

TrackVideo::TrackVideo(const std::filesystem::path& path) {
  throw Error("this rastro was built without video files", path.string(),
              "omit --video, use --images, or build with -DRASTRO_WITH_VIDEO=ON");
}
void TrackVideo::write(const TrackFrame&, GrayView) {}
void TrackVideo::finish() {}
#endif

TrackVideo::~TrackVideo() = default;

}  // namespace rastro
