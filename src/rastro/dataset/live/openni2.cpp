// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/openni2.h"

#include "rastro/base/error.h"

#if RASTRO_WITH_OPENNI2

#include <OpenNI.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "rastro/base/text.h"
#include "rastro/dataset/depth_readings.h"
#include "rastro/dataset/live/camera_image.h"

namespace rastro {
namespace {

constexpr double units_per_meter = 1000.0;
constexpr std::int64_t ns_per_us = 1000;
constexpr std::int64_t longest_pairing_us = 20'000;

std::string reason() { return one_line(std::string(trim(openni::OpenNI::getExtendedError()))); }

/// OpenNI2 may be initialized once in a program; it finds its drivers beside its library.
void initialize() {
  static const openni::Status status = openni::OpenNI::initialize();
  if (status != openni::STATUS_OK)
    throw Error("OpenNI2 does not start (" + reason() + ")", "openni2:", "are its drivers installed?");
}

class Openni2Device final : public CameraDevice {
 public:
  Openni2Device(const std::string& file, const std::string& address, bool want_color, const DepthReadings& readings,
                Clock& clock)
      : address_(address), want_color_(want_color), readings_(readings), clock_(clock), offset_(epoch_offset(clock)) {
    initialize();
    if (device_.open(file.empty() ? openni::ANY_DEVICE : file.c_str()) != openni::STATUS_OK)
      throw DeviceGone("cannot be opened (" + reason() + ")", address,
                       file.empty() ? "'rastro devices' lists what is connected"
                                    : "is it a recording of OpenNI2, or a camera's URI?");
    is_file_ = device_.isFile();
    can_register_ = device_.isImageRegistrationModeSupported(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR);
    if (can_register_)
      device_.setImageRegistrationMode(readings.device_registers ? openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR
                                                                 : openni::IMAGE_REGISTRATION_OFF);
    device_.setDepthColorSyncEnabled(true);
    start(openni::SENSOR_DEPTH, depth_);
    start(openni::SENSOR_COLOR, color_);
    if (!depth_.isValid()) throw DeviceGone("has no depth", address, "");
    if (is_file_) device_.getPlaybackControl()->setRepeatEnabled(false);
  }

  ~Openni2Device() override {
    // Frames are the streams'.
    depth_frame_.release();
    color_frame_.release();
    for (openni::VideoStream* stream : {&depth_, &color_})
      if (stream->isValid()) stream->stop();
    // The thread of the file device goes on until it is closed, and uses the streams.
    if (is_file_) device_.close();
    for (openni::VideoStream* stream : {&depth_, &color_})
      if (stream->isValid()) stream->destroy();
    device_.close();
  }

  ImageSize size() const {
    const openni::VideoMode mode = (color_.isValid() ? color_ : depth_).getVideoMode();
    return {mode.getResolutionX(), mode.getResolutionY()};
  }

  /// Depth beside color that nobody puts into its image. A recording holds it as it was recorded.
  bool lacks_registration() const {
    return readings_.device_registers && color_.isValid() && !can_register_ && !is_file_;
  }

  /// Of the depth camera, which is that of the color image where it is registered to it; 0: not told.
  double horizontal_field_of_view_deg() const {
    constexpr double degrees = 180.0 / 3.14159265358979323846;
    const float radians = (color_.isValid() ? color_ : depth_).getHorizontalFieldOfView();
    return std::isfinite(radians) ? static_cast<double>(radians) * degrees : 0.0;
  }

  std::optional<ArrivedFrame> next(TimeNs patience) override {
    const TimeNs until = clock_.now() + patience;
    while (clock_.now() <= until) {
      if (auto arrived = paired()) return arrived;
      if (!read_one(until)) break;
    }
    if (is_at_end()) ended_ = true;
    return std::nullopt;
  }

  bool has_ended() const override { return ended_; }

 private:
  void start(openni::SensorType type, openni::VideoStream& stream) {
    if (device_.getSensorInfo(type) == nullptr) return;
    if (stream.create(device_, type) != openni::STATUS_OK || stream.start() != openni::STATUS_OK)
      throw DeviceGone("does not start (" + reason() + ")", address_, "");
  }

  bool read_one(TimeNs until) {
    constexpr TimeNs ns_per_ms = 1'000'000;
    openni::VideoStream* streams[] = {&depth_, &color_};
    int ready = -1;
    const int wait_ms = static_cast<int>(std::max<TimeNs>(1, (until - clock_.now()) / ns_per_ms));
    const openni::Status status = openni::OpenNI::waitForAnyStream(streams, color_.isValid() ? 2 : 1, &ready, wait_ms);
    if (status == openni::STATUS_TIME_OUT) return false;
    if (status != openni::STATUS_OK || ready < 0) throw DeviceGone("is gone (" + reason() + ")", address_, "");
    openni::VideoFrameRef& frame = ready == 0 ? depth_frame_ : color_frame_;
    if (streams[ready]->readFrame(&frame) != openni::STATUS_OK)
      throw DeviceGone("is gone (" + reason() + ")", address_, "");
    last_read_ = clock_.now();
    if (is_file_) note_number(frame, ready == 0 ? depth_ : color_);
    return true;
  }

  void note_number(const openni::VideoFrameRef& frame, const openni::VideoStream& stream) {
    const int frames = device_.getPlaybackControl()->getNumberOfFrames(stream);
    if (frames > 0 && frame.getFrameIndex() >= frames) at_last_ = true;
  }

  /// The file device does not tell that it has ended: nothing comes any more.
  bool is_at_end() const {
    return is_file_ && last_read_ && (at_last_ || clock_.now() - *last_read_ > 2 * ns_per_second);
  }

  /// A color image with its depth, or depth alone where there is no color.
  std::optional<ArrivedFrame> paired() {
    if (!depth_frame_.isValid() || (color_.isValid() && !color_frame_.isValid())) return std::nullopt;
    const auto depth_us = static_cast<std::int64_t>(depth_frame_.getTimestamp());
    if (!color_.isValid()) return arrived_at(depth_us, depth_us);
    const auto color_us = static_cast<std::int64_t>(color_frame_.getTimestamp());
    if (std::abs(depth_us - color_us) > longest_pairing_us) {
      (depth_us < color_us ? depth_frame_ : color_frame_).release();
      return std::nullopt;
    }
    return arrived_at(color_us, depth_us);
  }

  ArrivedFrame arrived_at(std::int64_t image_us, std::int64_t depth_us) {
    ArrivedFrame arrived;
    arrived.exposed = clock_.now();
    Frame& frame = arrived.frame;
    // Of the device's clock, which begins when it likes: its first image is taken to be taken when it arrives.
    if (!first_us_) {
      first_us_ = image_us;
      first_stamp_ = is_file_ ? image_us * ns_per_us : arrived.exposed + offset_;
    }
    frame.stamp = first_stamp_ + (image_us - *first_us_) * ns_per_us;
    frame.depth_stamp = first_stamp_ + (depth_us - *first_us_) * ns_per_us;
    read_depth(frame);
    if (color_.isValid()) {
      read_color(frame);
    } else {
      frame.image = GrayImage(frame.depth.width(), frame.depth.height());
    }
    depth_frame_.release();
    color_frame_.release();
    if (readings_.device_registers &&
        (frame.depth.width() != frame.image.width() || frame.depth.height() != frame.image.height()))
      throw Error("depth and color have different sizes", address_, "set one size for both in OpenNI2's settings");
    return arrived;
  }

  void read_depth(Frame& frame) const {
    const openni::VideoMode mode = depth_frame_.getVideoMode();
    const bool tenths = mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM;
    const float to_meters = static_cast<float>(tenths ? 0.1 / units_per_meter : 1.0 / units_per_meter);
    frame.depth = DepthImage(depth_frame_.getWidth(), depth_frame_.getHeight());
    const auto* bytes = static_cast<const unsigned char*>(depth_frame_.getData());
    for (int y = 0; y < frame.depth.height(); ++y) {
      const auto* row = reinterpret_cast<const std::uint16_t*>(bytes + y * depth_frame_.getStrideInBytes());
      for (int x = 0; x < frame.depth.width(); ++x)
        frame.depth.at(x, y) = readings_.corrected(static_cast<float>(row[x]) * to_meters);
    }
  }

  void read_color(Frame& frame) const {
    const int width = color_frame_.getWidth(), height = color_frame_.getHeight();
    const auto stride = static_cast<std::size_t>(color_frame_.getStrideInBytes());
    const auto* bytes = static_cast<const unsigned char*>(color_frame_.getData());
    switch (color_frame_.getVideoMode().getPixelFormat()) {
      case openni::PIXEL_FORMAT_RGB888:
        return convert_rgb(bytes, width, height, stride, want_color_, frame);
      case openni::PIXEL_FORMAT_GRAY8:
        return convert_grey(bytes, width, height, stride, want_color_, frame);
      case openni::PIXEL_FORMAT_YUYV:
        return convert_yuyv(bytes, width, height, stride, want_color_, frame);
      default:
        throw Error("gives colors in a format that is not supported", address_, "");
    }
  }

  std::string address_;
  bool want_color_;
  DepthReadings readings_;
  bool is_file_ = false, can_register_ = false;
  Clock& clock_;
  TimeNs offset_;
  openni::Device device_;
  openni::VideoStream depth_, color_;
  openni::VideoFrameRef depth_frame_, color_frame_;
  std::optional<std::int64_t> first_us_;
  TimeNs first_stamp_ = 0;
  std::optional<TimeNs> last_read_;
  bool at_last_ = false, ended_ = false;
};

}  // namespace

std::unique_ptr<LiveSource> open_openni2(const std::string& address, const std::string& file,
                                         const OpenOptions& options, Clock& clock) {
  const DepthReadings readings = depth_readings(options, units_per_meter);
  const auto open_device = [address, file, color = options.want_color, readings, &clock] {
    return std::make_unique<Openni2Device>(file, address, color, readings, clock);
  };
  auto device = open_device();
  OpenOptions calibrated = options;
  // The device's own: a pinhole of the angle that it tells.
  const bool given = options.intrinsics || options.field_of_view_deg || !options.calibration_file.empty();
  const double angle = device->horizontal_field_of_view_deg();
  if (!given && angle > 1.0 && angle < 179.0) calibrated.field_of_view_deg = angle;
  SourceInfo info = camera_info(address, "live_openni2", device->size(), calibrated);
  if (!given && info.cameras.front().camera) info.cameras.front().calibration_file = "OpenNI2's field of view";
  describe_depth(readings, info);
  if (device->lacks_registration())
    info.warnings.push_back(address +
                            ": the camera does not register its depth to color; 'rastro calibrate --depth "
                            "--depth-camera FILE' measures how");
  return make_live_camera(std::move(info), std::move(device), open_device, options, {}, clock);
}

std::vector<Openni2Listing> list_openni2() {
  initialize();
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  std::vector<Openni2Listing> list;
  for (int k = 0; k < devices.getSize(); ++k)
    list.push_back({devices[k].getUri(), fmt::format("{} {}", devices[k].getVendor(), devices[k].getName())});
  return list;
}

bool has_openni2() { return true; }

}  // namespace rastro

#else

namespace rastro {

std::unique_ptr<LiveSource> open_openni2(const std::string& address, const std::string&, const OpenOptions&, Clock&) {
  throw Error("this build does not use OpenNI2", address,
              "install libopenni2-dev and build with -DRASTRO_WITH_OPENNI2=ON");
}

std::vector<Openni2Listing> list_openni2() { return {}; }
bool has_openni2() { return false; }

}  // namespace rastro

#endif
