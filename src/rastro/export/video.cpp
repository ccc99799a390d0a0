// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/video.h"

#include <algorithm>
#include <utility>

#include "rastro/export/drawing.h"
#include "rastro/export/video_file.h"

namespace rastro {

/// The rate is known with the second frame, so the first one waits for it.
class TrackVideo::Writer {
 public:
  explicit Writer(const std::filesystem::path& path) : file_(path) {}

  void write(const TrackFrame& frame, GrayView image) {
    cv::Mat drawn = drawing::overlay(frame, image);
    if (!first_.empty()) {
      rate_hz_ = rate_between(first_stamp_, frame.stamp);
      file_.write(std::exchange(first_, cv::Mat()), rate_hz_);
    } else if (!begun_) {
      first_ = drawn;
      first_stamp_ = frame.stamp;
      begun_ = true;
      return;
    }
    file_.write(drawn, rate_hz_);
  }

  void finish() {
    if (!first_.empty()) file_.write(std::exchange(first_, cv::Mat()), usual_rate_hz);  // a run of one frame
    file_.finish();
  }

 private:
  static constexpr double usual_rate_hz = 20.0;

  static double rate_between(TimeNs first, TimeNs second) {
    if (second <= first) return usual_rate_hz;
    return std::clamp(1.0 / to_seconds(second - first), 1.0, 120.0);
  }

  detail::VideoFile file_;
  cv::Mat first_;
  TimeNs first_stamp_ = 0;
  double rate_hz_ = usual_rate_hz;
  bool begun_ = false;
};

TrackVideo::TrackVideo(const std::filesystem::path& path) : writer_(std::make_unique<Writer>(path)) {}
void TrackVideo::write(const TrackFrame& frame, GrayView image) { writer_->write(frame, image); }
void TrackVideo::finish() { writer_->finish(); }
TrackVideo::~TrackVideo() = default;

}  // namespace rastro
