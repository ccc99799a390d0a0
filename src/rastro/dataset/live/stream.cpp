// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/stream.h"

#include "rastro/base/error.h"

#if RASTRO_WITH_VIDEO

#include <opencv2/videoio.hpp>

#include "rastro/dataset/mat_conversion.h"

namespace rastro {
namespace {

constexpr int open_within_ms = 5000;
// During a run: a program that is asked to end must not wait longer.
constexpr int image_within_ms = 1500;

class StreamDevice final : public CameraDevice {
 public:
  StreamDevice(std::string address, bool want_color, int within_ms, Clock& clock)
      : address_(std::move(address)), want_color_(want_color), clock_(clock), offset_(epoch_offset(clock)) {
    try {
      video_.open(address_, cv::CAP_FFMPEG,
                  {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, within_ms, cv::CAP_PROP_READ_TIMEOUT_MSEC, image_within_ms});
    } catch (const cv::Exception&) {
      video_.release();
    }
    if (!video_.isOpened())
      throw Error("cannot be opened as a stream of images", address_, "is the camera on, and the address right?");
  }

  ImageSize size() {
    return {static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
            static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT))};
  }

  /// Waits for image_within_ms whatever the patience: the back-end cannot be asked for less.
  std::optional<ArrivedFrame> next(TimeNs) override {
    cv::Mat mat;
    if (!video_.grab()) throw DeviceGone("ended or sends nothing", address_, "");
    ArrivedFrame arrived;
    arrived.exposed = clock_.now();
    arrived.frame.stamp = arrived.exposed + offset_;
    if (!video_.retrieve(mat) || mat.empty()) throw Error("an image cannot be decoded", address_, "");
    DecodedImage image;
    const std::string reason = convert(mat, want_color_, image);
    if (!reason.empty()) throw Error(reason, address_, "");
    arrived.frame.image = std::move(image.gray);
    arrived.frame.color = std::move(image.color);
    return arrived;
  }

 private:
  std::string address_;
  bool want_color_;
  Clock& clock_;
  TimeNs offset_;
  cv::VideoCapture video_;
};

}  // namespace

std::unique_ptr<LiveSource> open_stream(const std::string& address, const OpenOptions& options, Clock& clock) {
  const auto open_device = [address, color = options.want_color, &clock](int within_ms) {
    return std::make_unique<StreamDevice>(address, color, within_ms, clock);
  };
  auto device = open_device(open_within_ms);
  const ImageSize size = device->size();
  const auto known = size.width > 0 && size.height > 0 ? std::optional(size) : std::nullopt;
  const auto reopen = [open_device, limit = ReopenLimit(image_within_ms, open_within_ms)]() mutable {
    auto again = open_device(limit.take_ms());
    limit.reset();
    return again;
  };
  return make_live_camera(camera_info(address, "live_stream", known, options), std::move(device), reopen, options, {},
                          clock);
}

}  // namespace rastro

#else

namespace rastro {

std::unique_ptr<LiveSource> open_stream(const std::string& address, const OpenOptions&, Clock&) {
  throw Error("this build does not read streams", address, "build with -DRASTRO_WITH_VIDEO=ON");
}

}  // namespace rastro

#endif
