// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/freenect_system.h"

#if RASTRO_WITH_FREENECT

#include <libfreenect.h>
#include <sys/time.h>

#include <algorithm>
#include <utility>

namespace rastro {
namespace {

/// The library's state, with one camera at most.
class Context {
 public:
  Context() {
    if (freenect_init(&context_, nullptr) != 0) {
      context_ = nullptr;
      return;
    }
    // It prints on standard error otherwise.
    freenect_set_log_level(context_, FREENECT_LOG_FATAL);
    freenect_select_subdevices(context_, FREENECT_DEVICE_CAMERA);
  }
  ~Context() {
    if (context_ != nullptr) freenect_shutdown(context_);
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  freenect_context* get() const { return context_; }

 private:
  freenect_context* context_ = nullptr;
};

class Kinect final : public FreenectCamera {
 public:
  ~Kinect() override {
    if (device_ == nullptr) return;
    freenect_stop_depth(device_);
    freenect_stop_video(device_);
    freenect_close_device(device_);
  }

  bool start(int number, bool registered) {
    if (context_.get() == nullptr || freenect_open_device(context_.get(), &device_, number) != 0) {
      device_ = nullptr;
      return false;
    }
    const auto color = freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB);
    const auto depth = freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM,
                                                registered ? FREENECT_DEPTH_REGISTERED : FREENECT_DEPTH_MM);
    color_buffer_.resize(static_cast<std::size_t>(std::max(0, color.bytes)));
    depth_buffer_.resize(static_cast<std::size_t>(std::max(0, depth.bytes)));
    freenect_set_user(device_, this);
    freenect_set_video_callback(device_, keep_color);
    freenect_set_depth_callback(device_, keep_depth);
    return color.is_valid != 0 && depth.is_valid != 0 && freenect_set_video_mode(device_, color) == 0 &&
           freenect_set_depth_mode(device_, depth) == 0 &&
           freenect_set_video_buffer(device_, color_buffer_.data()) == 0 &&
           freenect_set_depth_buffer(device_, depth_buffer_.data()) == 0 && freenect_start_depth(device_) == 0 &&
           freenect_start_video(device_) == 0;
  }

  bool wait(TimeNs at_most) override {
    constexpr TimeNs ns_per_us = 1000;
    timeval time{};
    time.tv_sec = static_cast<time_t>(at_most / ns_per_second);
    time.tv_usec = static_cast<suseconds_t>(at_most % ns_per_second / ns_per_us);
    return freenect_process_events_timeout(context_.get(), &time) >= 0;
  }

  std::optional<FreenectImage> take_color() override { return std::exchange(color_, std::nullopt); }
  std::optional<FreenectImage> take_depth() override { return std::exchange(depth_, std::nullopt); }

 private:
  static void keep_color(freenect_device* device, void*, std::uint32_t ticks) {
    auto* self = static_cast<Kinect*>(freenect_get_user(device));
    self->color_ = FreenectImage{self->color_buffer_, ticks};
  }
  static void keep_depth(freenect_device* device, void*, std::uint32_t ticks) {
    auto* self = static_cast<Kinect*>(freenect_get_user(device));
    self->depth_ = FreenectImage{self->depth_buffer_, ticks};
  }

  Context context_;
  freenect_device* device_ = nullptr;
  std::vector<std::uint8_t> color_buffer_, depth_buffer_;
  std::optional<FreenectImage> color_, depth_;
};

class Library final : public FreenectSystem {
 public:
  std::vector<std::string> serials() override {
    const Context context;
    freenect_device_attributes* first = nullptr;
    std::vector<std::string> serials;
    if (context.get() == nullptr || freenect_list_device_attributes(context.get(), &first) < 0) return serials;
    for (const auto* each = first; each != nullptr; each = each->next)
      serials.emplace_back(each->camera_serial != nullptr ? each->camera_serial : "");
    freenect_free_device_attributes(first);
    return serials;
  }

  std::unique_ptr<FreenectCamera> open(int number, bool registered) override {
    auto camera = std::make_unique<Kinect>();
    return camera->start(number, registered) ? std::move(camera) : nullptr;
  }
};

}  // namespace

FreenectSystem* freenect_system() {
  static Library library;
  return &library;
}

}  // namespace rastro

#else

namespace rastro {

FreenectSystem* freenect_system() { return nullptr; }

}  // namespace rastro

#endif
