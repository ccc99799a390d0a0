// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/freenect.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "rastro/base/text.h"
#include "rastro/dataset/depth_readings.h"
#include "rastro/dataset/live/camera_image.h"

namespace rastro {
namespace {

constexpr int width = 640, height = 480;
constexpr double units_per_meter = 1000.0;
/// Of the color camera: a focal length of 525 pixels, as most have within 2 %.
constexpr double usual_field_of_view_deg = 62.7;
constexpr TimeNs longest_pairing = 20'000'000;

/// Nanoseconds from the first image on; the camera's clock goes round.
class TickClock {
 public:
  TimeNs time_of(std::uint32_t ticks) {
    if (!last_) last_ = ticks;
    // The difference of two stamps that lie less than half a round apart, also back in time.
    total_ += static_cast<std::int32_t>(ticks - *last_);
    last_ = ticks;
    return total_ * 50 / 3;  // 60 MHz
  }

 private:
  std::optional<std::uint32_t> last_;
  std::int64_t total_ = 0;
};

struct Timed {
  FreenectImage image;
  TimeNs at = 0;
};

class FreenectDevice final : public CameraDevice {
 public:
  FreenectDevice(std::unique_ptr<FreenectCamera> camera, const std::string& address, bool want_color,
                 const DepthReadings& readings, Clock& clock)
      : camera_(std::move(camera)),
        address_(address),
        want_color_(want_color),
        readings_(readings),
        clock_(clock),
        offset_(epoch_offset(clock)) {}

  std::optional<ArrivedFrame> next(TimeNs patience) override {
    const TimeNs until = clock_.now() + patience;
    do {
      if (auto arrived = paired()) return arrived;
      if (!camera_->wait(std::max<TimeNs>(0, until - clock_.now()))) throw DeviceGone("is gone", address_, "");
      take();
    } while (clock_.now() < until);
    return paired();
  }

 private:
  void take() {
    // Both in the order of their stamps does not matter: half a round is 36 s.
    if (auto depth = camera_->take_depth()) depth_ = timed(std::move(*depth));
    if (auto color = camera_->take_color()) color_ = timed(std::move(*color));
  }

  Timed timed(FreenectImage image) {
    const TimeNs at = ticks_.time_of(image.ticks);
    return {std::move(image), at};
  }

  std::optional<ArrivedFrame> paired() {
    if (!color_ || !depth_) return std::nullopt;
    if (std::abs(color_->at - depth_->at) > longest_pairing) {
      (color_->at < depth_->at ? color_ : depth_).reset();
      return std::nullopt;
    }
    ArrivedFrame arrived;
    arrived.exposed = clock_.now();
    // The camera's clock begins when it likes: its first image is taken to be taken when it arrives.
    if (!begin_) begin_ = arrived.exposed + offset_ - color_->at;
    arrived.frame.stamp = *begin_ + color_->at;
    arrived.frame.depth_stamp = *begin_ + depth_->at;
    read_color(arrived.frame);
    read_depth(arrived.frame);
    color_.reset();
    depth_.reset();
    return arrived;
  }

  void read_color(Frame& frame) const {
    constexpr std::size_t stride = 3 * width;
    if (color_->image.bytes.size() < stride * height) throw Error("gives a part of an image", address_, "");
    convert_rgb(color_->image.bytes.data(), width, height, stride, want_color_, frame);
  }

  void read_depth(Frame& frame) const {
    constexpr auto to_meters = static_cast<float>(1.0 / units_per_meter);
    if (depth_->image.bytes.size() < std::size_t{2} * width * height)
      throw Error("gives a part of a depth image", address_, "");
    frame.depth = DepthImage(width, height);
    const std::uint8_t* bytes = depth_->image.bytes.data();
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x, bytes += 2) {
        std::uint16_t reading = 0;
        std::memcpy(&reading, bytes, sizeof reading);
        frame.depth.at(x, y) = readings_.corrected(static_cast<float>(reading) * to_meters);
      }
  }

  std::unique_ptr<FreenectCamera> camera_;
  std::string address_;
  bool want_color_;
  DepthReadings readings_;
  Clock& clock_;
  TimeNs offset_;
  TickClock ticks_;
  std::optional<Timed> color_, depth_;
  std::optional<TimeNs> begin_;
};

int number_in(const std::string& text, const std::string& address) {
  constexpr int most = 63;
  const auto number = text.empty() ? std::optional<std::int64_t>(0) : parse_int64(text);
  if (!number || *number < 0 || *number > most)
    throw Error("names no Kinect", address, "give freenect:0 for the first one; 'rastro devices' lists them");
  return static_cast<int>(*number);
}

}  // namespace

std::unique_ptr<LiveSource> open_freenect(const std::string& address, const std::string& number,
                                          const OpenOptions& options, FreenectSystem* system, Clock& clock) {
  const int which = number_in(number, address);
  if (system == nullptr)
    throw Error(
        "this build does not use libfreenect", address,
        "install libfreenect-dev and build with -DRASTRO_WITH_FREENECT=ON, or give openni2: with FreenectDriver");
  const DepthReadings readings = depth_readings(options, units_per_meter);
  const auto open_device = [address, which, readings, color = options.want_color, system, &clock] {
    auto camera = system->open(which, readings.device_registers);
    if (!camera)
      throw DeviceGone(
          "cannot be opened", address,
          "is it connected and has power? 'rastro devices' lists what is; may this user use it (udev rules)?");
    return std::make_unique<FreenectDevice>(std::move(camera), address, color, readings, clock);
  };
  auto device = open_device();
  OpenOptions calibrated = options;
  const bool given = options.intrinsics || options.field_of_view_deg || !options.calibration_file.empty();
  if (!given) calibrated.field_of_view_deg = usual_field_of_view_deg;
  SourceInfo info = camera_info(address, "live_freenect", ImageSize{width, height}, calibrated);
  if (!given) info.cameras.front().calibration_file = "the usual lens of a Kinect 1";
  describe_depth(readings, info);
  return make_live_camera(std::move(info), std::move(device), open_device, options, {}, clock);
}

}  // namespace rastro
