// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/live_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "rastro/dataset/calibration.h"
#include "rastro/dataset/recording.h"

namespace rastro {
namespace {

class LiveCamera final : public LiveSource {
 public:
  LiveCamera(SourceInfo info, std::unique_ptr<CameraDevice> device, OpenDevice reopen, const OpenOptions& choice,
             const LiveCameraOptions& options, Clock& clock)
      : info_(std::move(info)),
        device_(std::move(device)),
        reopen_(std::move(reopen)),
        choice_(choice, std::numeric_limits<std::int64_t>::max(), info_.path),
        options_(options),
        clock_(clock),
        last_image_(clock.now()) {}

  const SourceInfo& info() const override { return info_; }
  LiveCondition condition() const override { return condition_; }

  std::optional<ArrivedFrame> next(TimeNs patience) override {
    if (condition_.state == LiveState::ended) return std::nullopt;
    if (!device_) {
      open_again(patience);
      return std::nullopt;
    }
    try {
      auto arrived = device_->next(patience);
      if (arrived) return received(std::move(*arrived));
      note_silence();
    } catch (const DeviceGone& gone) {
      device_.reset();
      lose(gone.what());
    }
    return std::nullopt;
  }

 private:
  void open_again(TimeNs patience) {
    if (clock_.now() < next_try_) return clock_.sleep_for(std::min(patience, next_try_ - clock_.now()));
    try {
      device_ = reopen_();
      last_image_ = clock_.now();
    } catch (const Error& error) {
      lose(error.what());
    }
  }

  void lose(const std::string& why) {
    condition_ = {LiveState::gone, why + "; waiting for it"};
    next_try_ = clock_.now() + options_.retry_every;
  }

  void note_silence() {
    if (device_->has_ended()) {
      condition_ = {LiveState::ended, ""};
    } else if (condition_.state == LiveState::delivering && clock_.now() - last_image_ > options_.stall_after) {
      condition_ = {LiveState::stalled,
                    fmt::format("{}: no image for {:g} s; waiting", info_.path, to_seconds(options_.stall_after))};
    }
  }

  std::optional<ArrivedFrame> received(ArrivedFrame arrived) {
    last_image_ = clock_.now();
    condition_ = {};
    lost_ += arrived.lost_before;
    const std::int64_t index = images_++;
    require_size(arrived.frame, index);
    if (index < choice_.first || (index - choice_.first) % choice_.every != 0) return std::nullopt;
    if (++chosen_ == choice_.count) condition_ = {LiveState::ended, ""};
    arrived.frame.index = index;
    arrived.frame.name = fmt::format("frame {}", index);
    arrived.lost_before = std::exchange(lost_, 0);
    return arrived;
  }

  void require_size(const Frame& frame, std::int64_t index) {
    const ImageSize size{frame.image.width(), frame.image.height()};
    if (first_size_.width == 0) first_size_ = size;
    if (size == first_size_) return;
    throw UnusableSource(fmt::format("image {} is {}x{}, but those before it {}x{}", index, size.width, size.height,
                                     first_size_.width, first_size_.height),
                         info_.path, "all images of a run must have one size");
  }

  SourceInfo info_;
  std::unique_ptr<CameraDevice> device_;  ///< Null while it is gone.
  OpenDevice reopen_;
  FrameChoice choice_;
  LiveCameraOptions options_;
  Clock& clock_;
  LiveCondition condition_;
  TimeNs last_image_, next_try_ = 0;
  std::int64_t images_ = 0, chosen_ = 0, lost_ = 0;
  ImageSize first_size_;
};

}  // namespace

std::unique_ptr<LiveSource> make_live_camera(SourceInfo info, std::unique_ptr<CameraDevice> device, OpenDevice reopen,
                                             const OpenOptions& choice, const LiveCameraOptions& options,
                                             Clock& clock) {
  return std::make_unique<LiveCamera>(std::move(info), std::move(device), std::move(reopen), choice, options, clock);
}

SourceInfo camera_info(const std::string& address, const std::string& format, std::optional<ImageSize> size,
                       const OpenOptions& options) {
  SourceInfo info;
  info.path = address;
  info.format = format;
  info.frame_count = -1;
  info.cameras.push_back(uncalibrated("camera"));
  finish_calibration(info, options, size);
  return info;
}

TimeNs epoch_offset(const Clock& clock) {
  const auto since_epoch = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since_epoch).count() - clock.now();
}

}  // namespace rastro
