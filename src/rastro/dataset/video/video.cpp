// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/video/video.h"

#include "rastro/base/error.h"

#if RASTRO_WITH_VIDEO

#include <fmt/format.h>

#include <cmath>
#include <opencv2/videoio.hpp>

#include "rastro/base/log.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/mat_conversion.h"
#include "rastro/dataset/recording.h"

namespace rastro {
namespace {

constexpr double usual_rate_hz = 30.0;

class VideoSource final : public Source {
 public:
  VideoSource(const std::string& path, const OpenOptions& options) : options_(options) {
    open_file(path);
    const double count = video_.get(cv::CAP_PROP_FRAME_COUNT);
    const double rate = video_.get(cv::CAP_PROP_FPS);
    info_.path = path;
    info_.format = "video";
    info_.frame_count = count >= 1.0 && count < 1e12 ? std::llround(count) : -1;
    info_.has_stamps = options.rate_hz <= 0.0 && std::isfinite(rate) && rate > 0.0;
    rate_hz_ = options.rate_hz > 0.0 ? options.rate_hz : info_.has_stamps ? rate : usual_rate_hz;
    info_.cameras.push_back({"video", std::nullopt, std::nullopt, ""});
    finish_calibration(info_, options, frame_size());
    // The count in the header is often an estimate: the end of the choice is not cut by it.
    choice_ = FrameChoice(options, std::numeric_limits<std::int64_t>::max(), path);
    seek(choice_.first);
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (position_ >= choice_.count) return std::nullopt;
    const std::int64_t wanted = choice_.index(position_++);
    while (at_ < wanted) {
      if (!grab()) return end();
    }
    cv::Mat mat;
    if (!grab() || !retrieve(mat)) return end();
    return make_frame(wanted, mat);
  }

 private:
  void open_file(const std::string& path) {
    try {
      // Named, because the other backends print on failure.
      video_.open(path, cv::CAP_FFMPEG);
    } catch (const cv::Exception& exception) {
      throw Error("cannot be opened as a video (" + exception.err + ")", path, "");
    }
    if (!video_.isOpened())
      throw Error("cannot be opened as a video", path, "it is damaged or of a kind this OpenCV does not read");
  }

  std::optional<ImageSize> frame_size() {
    const ImageSize size{static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
                         static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT))};
    return size.width > 0 && size.height > 0 ? std::optional(size) : std::nullopt;
  }

  /// Frames are counted, not sought by time: only then is the frame number right with every codec.
  void seek(std::int64_t frame) {
    while (at_ < frame)
      if (!grab()) throw Error(fmt::format("frame {} does not exist, the video has {}", frame, at_), "--frames", "");
  }

  bool grab() {
    if (!video_.grab()) return false;
    stamp_ = stamp_of(at_++);
    return true;
  }

  /// Phones vary their rate, so the presentation time counts. Where a file has none, or times that do not rise, a
  /// period after the frame before.
  TimeNs stamp_of(std::int64_t index) {
    if (!info_.has_stamps) return made_up_stamp(index, rate_hz_);
    constexpr double longest_ms = 1e12;
    const double ms = video_.get(cv::CAP_PROP_POS_MSEC);
    const bool known = ms >= 0.0 && ms < longest_ms;
    const TimeNs stamp = known ? static_cast<TimeNs>(std::llround(ms * 1e6)) : 0;
    if (index == 0 || stamp > stamp_) return stamp;
    return stamp_ + made_up_stamp(1, rate_hz_);
  }

  /// A file that was cut off, as by a full disk, still says how long it was; else the count may be an estimate.
  std::optional<Frame> end() {
    constexpr double usual_error = 0.1;
    if (static_cast<double>(at_) < (1.0 - usual_error) * static_cast<double>(info_.frame_count) && !ended_)
      log_warning(fmt::format("{}: ends after {} frames, and says that it has {}: it may be cut off or damaged",
                              info_.path, at_, info_.frame_count));
    ended_ = true;
    return std::nullopt;
  }

  bool retrieve(cv::Mat& mat) { return video_.retrieve(mat) && !mat.empty(); }

  Frame make_frame(std::int64_t index, const cv::Mat& mat) {
    Frame frame;
    frame.index = index;
    frame.name = fmt::format("frame {}", index);
    frame.stamp = stamp_;
    DecodedImage image;
    const auto reason = convert(mat, options_.want_color, image);
    if (!reason.empty()) throw Error(reason, info_.path, "");
    const ImageSize size{image.gray.width(), image.gray.height()};
    if (first_size_.width == 0) first_size_ = size;
    if (first_size_ != size) {
      throw UnusableSource(fmt::format("frame {} is {}x{}, but those before it {}x{}", index, size.width, size.height,
                                       first_size_.width, first_size_.height),
                           info_.path, "all frames must have one size");
    }
    frame.image = std::move(image.gray);
    frame.color = std::move(image.color);
    return frame;
  }

  OpenOptions options_;
  SourceInfo info_;
  cv::VideoCapture video_;
  FrameChoice choice_;
  ImageSize first_size_;
  double rate_hz_ = usual_rate_hz;
  std::int64_t at_ = 0;  ///< Number of the next frame that grab() gives.
  TimeNs stamp_ = 0;     ///< Of the frame that it gave last.
  std::int64_t position_ = 0;
  bool ended_ = false;
};

}  // namespace

std::unique_ptr<Source> open_video(const std::string& path, const OpenOptions& options) {
  if (!has_video_ending(path))
    throw Error("is neither an image nor a video, laser log, landmark log or bag", path,
                "give a folder, a pattern or one of these");
  if (!options.camera.empty() && options.calibration_file.empty())
    throw Error("a video has no named cameras", "--camera", "omit it, or give a --calibration that has");
  return std::make_unique<VideoSource>(path, options);
}

}  // namespace rastro

#else

namespace rastro {

std::unique_ptr<Source> open_video(const std::string& path, const OpenOptions&) {
  throw Error("this build does not read videos", path,
              "build with -DRASTRO_WITH_VIDEO=ON, or convert the video to images");
}

}  // namespace rastro

#endif
