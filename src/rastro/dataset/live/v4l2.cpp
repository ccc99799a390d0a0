// SPDX-License-Identifier: Apache-2.0
// The API: https://www.kernel.org/doc/html/v6.1/userspace-api/media/v4l/v4l2.html
#include "rastro/dataset/live/v4l2.h"

#include "rastro/base/error.h"

#if RASTRO_WITH_V4L2

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>
#include <utility>

#include "rastro/base/text.h"
#include "rastro/dataset/live/camera_image.h"

namespace rastro {
namespace {

constexpr ImageSize usual_size{640, 480};
constexpr unsigned buffers_wanted = 4;
constexpr double rate_tolerance = 0.9;

struct Format {
  std::string_view name;
  std::uint32_t code;
};
/// In the order of preference: without loss and cheap first.
constexpr Format formats[] = {{"GREY", V4L2_PIX_FMT_GREY}, {"YUYV", V4L2_PIX_FMT_YUYV}, {"MJPG", V4L2_PIX_FMT_MJPEG}};

std::string text_of(int code) { return std::generic_category().message(code); }

template <typename T>
T zeroed() {
  T value;
  std::memset(&value, 0, sizeof(value));
  return value;
}

/// One line of what is wrong and what to do, for a failed open().
std::string why_not_opened(const std::string& file, int code) {
  switch (code) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return file + ": is not there; is the camera plugged in? 'rastro devices' lists what is";
    case EACCES:
    case EPERM:
      return file +
             ": may not be opened; add yourself to the group video: 'sudo usermod -aG video $USER', then log in again";
    case EBUSY:
      return file + ": is in use by another program; close that";
    default:
      return fmt::format("{}: cannot be opened ({})", file, text_of(code));
  }
}

/// An open device file, closed at the end.
class Handle {
 public:
  Handle(V4l2System& system, const std::string& file) : system_(system), file_(file), descriptor_(system.open(file)) {
    if (descriptor_ < 0) throw DeviceGone(why_not_opened(file, errno));
  }
  ~Handle() { system_.close(descriptor_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  template <typename T>
  bool try_control(unsigned long request, T& argument) {
    return system_.ioctl(descriptor_, request, &argument) == 0;
  }
  template <typename T>
  void control(unsigned long request, T& argument, const char* what) {
    if (try_control(request, argument)) return;
    if (errno == EBUSY) throw DeviceGone(why_not_opened(file_, EBUSY));
    throw DeviceGone(fmt::format("{}: {} ({})", file_, what, text_of(errno)));
  }
  int descriptor() const { return descriptor_; }
  V4l2System& system() const { return system_; }
  const std::string& file() const { return file_; }

 private:
  V4l2System& system_;
  std::string file_;
  int descriptor_;
};

/// nullopt: it is no camera.
std::optional<std::string> camera_name(Handle& handle) {
  auto capability = zeroed<v4l2_capability>();
  if (!handle.try_control(VIDIOC_QUERYCAP, capability)) return std::nullopt;
  const std::uint32_t own =
      capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
  if (!(own & V4L2_CAP_VIDEO_CAPTURE) || !(own & V4L2_CAP_STREAMING)) return std::nullopt;
  const auto* name = reinterpret_cast<const char*>(capability.card);
  return std::string(name, strnlen(name, sizeof(capability.card)));
}

std::vector<std::uint32_t> formats_of(Handle& handle) {
  std::vector<std::uint32_t> codes;
  constexpr std::uint32_t most = 64;
  for (std::uint32_t index = 0; index < most; ++index) {
    auto description = zeroed<v4l2_fmtdesc>();
    description.index = index;
    description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (!handle.try_control(VIDIOC_ENUM_FMT, description)) break;
    codes.push_back(description.pixelformat);
  }
  return codes;
}

std::string four_letters(std::uint32_t code) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(code >> shift & 0x7F);
  return std::string(trim(text));
}

double rate_of(const v4l2_fract& interval) {
  return interval.numerator > 0 ? static_cast<double>(interval.denominator) / interval.numerator : 0.0;
}

/// What the driver made of a request.
struct Setting {
  v4l2_pix_format image;
  double rate_hz = 0.0;  ///< 0: it does not tell.
};

std::optional<Setting> set_mode(Handle& handle, const Format& format, const V4l2Request& request) {
  const ImageSize size = request.size.value_or(usual_size);
  auto wanted = zeroed<v4l2_format>();
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.fmt.pix.width = static_cast<std::uint32_t>(size.width);
  wanted.fmt.pix.height = static_cast<std::uint32_t>(size.height);
  wanted.fmt.pix.pixelformat = format.code;
  wanted.fmt.pix.field = V4L2_FIELD_NONE;
  handle.control(VIDIOC_S_FMT, wanted, "does not accept a format");
  const v4l2_pix_format& got = wanted.fmt.pix;
  const bool has_size =
      got.width == static_cast<std::uint32_t>(size.width) && got.height == static_cast<std::uint32_t>(size.height);
  if (got.pixelformat != format.code || (request.size && !has_size)) return std::nullopt;
  auto parameters = zeroed<v4l2_streamparm>();
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  parameters.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(1000.0 * request.rate_hz))};
  if (!handle.try_control(VIDIOC_S_PARM, parameters)) return Setting{got, 0.0};
  return Setting{got, rate_of(parameters.parm.capture.timeperframe)};
}

/// The first that reaches the rate, else the fastest.
Setting choose_mode(Handle& handle, const V4l2Request& request, bool want_color) {
  const auto offered = formats_of(handle);
  std::optional<Setting> best;
  const Format* best_format = nullptr;
  for (const Format& format : formats) {
    if (std::find(offered.begin(), offered.end(), format.code) == offered.end()) continue;
    if (request.format.empty() ? want_color && format.name == "GREY" && offered.size() > 1
                               : request.format != format.name)
      continue;
    const auto setting = set_mode(handle, format, request);
    if (!setting) continue;
    if (setting->rate_hz == 0.0 || setting->rate_hz >= rate_tolerance * request.rate_hz) return *setting;
    if (best && best->rate_hz >= setting->rate_hz) continue;
    best = setting;
    best_format = &format;
  }
  if (!best) {
    std::string names;
    for (const std::uint32_t code : offered) names += fmt::format(" {}", four_letters(code));
    throw Error("has no mode that fits; it offers" + (names.empty() ? " nothing" : names), handle.file(),
                "'rastro devices' lists sizes and rates; YUYV, MJPG and GREY can be read");
  }
  return set_mode(handle, *best_format, request).value_or(*best);
}

class V4l2Device final : public CameraDevice {
 public:
  V4l2Device(V4l2System& system, const V4l2Request& request, bool want_color, Clock& clock)
      : handle_(system, request.file), want_color_(want_color), clock_(clock), offset_(epoch_offset(clock)) {
    if (!camera_name(handle_)) throw Error("is no camera", request.file, "'rastro devices' lists the cameras");
    setting_ = choose_mode(handle_, request, want_color);
    require_plausible();
    try {
      start();
    } catch (...) {
      // Buffers that stay mapped keep the device in use, for this program too.
      unmap();
      throw;
    }
  }

  ~V4l2Device() override {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    handle_.try_control(VIDIOC_STREAMOFF, type);
    unmap();
  }

  ImageSize size() const { return {static_cast<int>(setting_.image.width), static_cast<int>(setting_.image.height)}; }

  std::optional<ArrivedFrame> next(TimeNs patience) override {
    constexpr TimeNs ns_per_ms = 1'000'000;
    const int ready = handle_.system().wait(handle_.descriptor(), static_cast<int>(patience / ns_per_ms));
    if (ready < 0) lose();
    if (ready == 0) return std::nullopt;
    auto buffer = buffer_request(0);
    if (!handle_.try_control(VIDIOC_DQBUF, buffer)) {
      if (errno == EAGAIN) return std::nullopt;
      lose();
    }
    if (buffer.index >= buffers_.size()) lose();
    const GiveBack when_done{*this, buffer.index};
    return read(buffer);
  }

 private:
  struct Buffer {
    void* address;
    std::size_t length;
  };
  struct GiveBack {
    V4l2Device& device;
    std::uint32_t index;
    ~GiveBack() { device.try_give_back(index); }
  };

  [[noreturn]] void lose() const {
    throw DeviceGone(handle_.file() + (errno == ENODEV || errno == EIO || errno == 0
                                           ? ": unplugged"
                                           : ": lost (" + text_of(errno) + ")"));
  }

  void require_plausible() const {
    constexpr std::uint32_t largest = 16384;
    const v4l2_pix_format& image = setting_.image;
    if (image.width == 0 || image.height == 0 || image.width > largest || image.height > largest)
      throw Error(fmt::format("gives images of {}x{}", image.width, image.height), handle_.file(), "");
  }

  static v4l2_buffer buffer_request(std::uint32_t index) {
    auto buffer = zeroed<v4l2_buffer>();
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    return buffer;
  }

  void start() {
    map_buffers();
    for (std::uint32_t index = 0; index < buffers_.size(); ++index) give_back(index);
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    handle_.control(VIDIOC_STREAMON, type, "does not start");
  }

  void map_buffers() {
    auto request = zeroed<v4l2_requestbuffers>();
    request.count = buffers_wanted;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    handle_.control(VIDIOC_REQBUFS, request, "gives no buffers");
    for (std::uint32_t index = 0; index < request.count; ++index) {
      auto buffer = buffer_request(index);
      handle_.control(VIDIOC_QUERYBUF, buffer, "gives no buffers");
      void* address = handle_.system().map(handle_.descriptor(), buffer.length, buffer.m.offset);
      if (!address) throw DeviceGone(fmt::format("{}: buffers cannot be mapped ({})", handle_.file(), text_of(errno)));
      buffers_.push_back({address, buffer.length});
    }
    if (buffers_.empty()) throw DeviceGone(handle_.file() + ": gives no buffers");
  }

  void unmap() {
    for (const Buffer& buffer : buffers_) handle_.system().unmap(buffer.address, buffer.length);
    buffers_.clear();
  }

  void give_back(std::uint32_t index) {
    auto buffer = buffer_request(index);
    handle_.control(VIDIOC_QBUF, buffer, "does not take a buffer");
  }
  /// A device that does not take it is gone, as the next call finds out.
  void try_give_back(std::uint32_t index) {
    auto buffer = buffer_request(index);
    handle_.try_control(VIDIOC_QBUF, buffer);
  }

  ArrivedFrame read(const v4l2_buffer& buffer) {
    ArrivedFrame arrived;
    if (last_sequence_ && buffer.sequence > *last_sequence_ + 1) lost_ += buffer.sequence - *last_sequence_ - 1;
    last_sequence_ = buffer.sequence;
    if (buffer.flags & V4L2_BUF_FLAG_ERROR) throw Error("an image is damaged", handle_.file(), "");
    const auto* bytes = static_cast<const unsigned char*>(buffers_[buffer.index].address);
    const std::size_t used = std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].length);
    convert_image(bytes, used, arrived.frame);
    arrived.exposed = time_of(buffer);
    arrived.frame.stamp = arrived.exposed + offset_;
    arrived.lost_before = std::exchange(lost_, 0);
    return arrived;
  }

  TimeNs time_of(const v4l2_buffer& buffer) const {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return clock_.now();
    return buffer.timestamp.tv_sec * ns_per_second + buffer.timestamp.tv_usec * 1000;
  }

  void convert_image(const unsigned char* bytes, std::size_t used, Frame& frame) const {
    const v4l2_pix_format& image = setting_.image;
    const int width = static_cast<int>(image.width), height = static_cast<int>(image.height);
    if (image.pixelformat == V4L2_PIX_FMT_MJPEG) return decode_jpeg({bytes, used}, want_color_, frame);
    const std::size_t pixel_bytes = image.pixelformat == V4L2_PIX_FMT_YUYV ? 2 : 1;
    const std::size_t row = pixel_bytes * image.width, stride = std::max<std::size_t>(image.bytesperline, row);
    if (used < stride * (image.height - 1) + row) throw Error("an image is cut short", handle_.file(), "");
    if (pixel_bytes == 2) return convert_yuyv(bytes, width, height, stride, want_color_, frame);
    convert_grey(bytes, width, height, stride, want_color_, frame);
  }

  Handle handle_;
  bool want_color_;
  Clock& clock_;
  TimeNs offset_;
  Setting setting_{};
  std::vector<Buffer> buffers_;
  std::optional<std::uint32_t> last_sequence_;
  std::int64_t lost_ = 0;  ///< Since the last image that could be used.
};

std::vector<double> rates_of(Handle& handle, std::uint32_t code, const ImageSize& size) {
  std::vector<double> rates;
  constexpr std::uint32_t most = 64;
  for (std::uint32_t index = 0; index < most; ++index) {
    auto interval = zeroed<v4l2_frmivalenum>();
    interval.index = index;
    interval.pixel_format = code;
    interval.width = static_cast<std::uint32_t>(size.width);
    interval.height = static_cast<std::uint32_t>(size.height);
    if (!handle.try_control(VIDIOC_ENUM_FRAMEINTERVALS, interval)) break;
    const bool discrete = interval.type == V4L2_FRMIVAL_TYPE_DISCRETE;
    rates.push_back(rate_of(discrete ? interval.discrete : interval.stepwise.min));
    if (!discrete) break;
  }
  std::sort(rates.rbegin(), rates.rend());
  return rates;
}

void add_modes(Handle& handle, std::uint32_t code, std::vector<V4l2Mode>& modes) {
  constexpr std::uint32_t most = 64;
  for (std::uint32_t index = 0; index < most; ++index) {
    auto size = zeroed<v4l2_frmsizeenum>();
    size.index = index;
    size.pixel_format = code;
    if (!handle.try_control(VIDIOC_ENUM_FRAMESIZES, size)) break;
    const bool discrete = size.type == V4L2_FRMSIZE_TYPE_DISCRETE;
    const ImageSize pixels{static_cast<int>(discrete ? size.discrete.width : size.stepwise.max_width),
                           static_cast<int>(discrete ? size.discrete.height : size.stepwise.max_height)};
    modes.push_back({four_letters(code), pixels, rates_of(handle, code, pixels)});
    if (!discrete) break;
  }
}

[[noreturn]] void refuse(const std::string& text) {
  throw Error(in_quotes(text) + " is not a camera",
              "v4l2:", "give v4l2:/dev/video0, v4l2:/dev/video0,1280x720@30 or v4l2:/dev/video0,1280x720@30,MJPG");
}

void read_mode(std::string_view word, const std::string& whole, V4l2Request& request) {
  const auto halves = split(word, '@');
  const auto sides = split(halves.front(), 'x');
  constexpr std::int64_t largest = 16384;
  const auto width = parse_int64(sides.front()), height = parse_int64(sides.back());
  if (halves.size() > 2 || sides.size() != 2 || !width || !height || *width < 1 || *height < 1 || *width > largest ||
      *height > largest)
    refuse(whole);
  request.size = ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
  if (halves.size() == 1) return;
  const auto rate = parse_finite(halves.back());
  if (!rate || !(*rate > 0.0 && *rate <= 1000.0)) refuse(whole);
  request.rate_hz = *rate;
}

}  // namespace

V4l2Request parse_v4l2_request(const std::string& text) {
  const auto words = split(text, ',');
  V4l2Request request;
  request.file = std::string(words.front());
  if (request.file.empty() || words.size() > 3) refuse(text);
  if (words.size() > 1) read_mode(words[1], text, request);
  if (words.size() > 2) {
    request.format = std::string(words[2]);
    const bool known = std::any_of(std::begin(formats), std::end(formats),
                                   [&](const Format& format) { return format.name == request.format; });
    if (!known) refuse(text);
  }
  return request;
}

std::unique_ptr<LiveSource> open_v4l2(const std::string& address, const std::string& text, const OpenOptions& options,
                                      V4l2System& system, Clock& clock) {
  const V4l2Request request = parse_v4l2_request(text);
  const auto open_device = [request, color = options.want_color, &system, &clock] {
    return std::make_unique<V4l2Device>(system, request, color, clock);
  };
  auto device = open_device();
  const ImageSize size = device->size();
  return make_live_camera(camera_info(address, "live_v4l2", size, options), std::move(device), open_device, options, {},
                          clock);
}

std::vector<V4l2Listing> list_v4l2(V4l2System& system) {
  std::vector<V4l2Listing> list;
  for (const std::string& file : system.device_files()) {
    V4l2Listing listing;
    listing.file = file;
    try {
      Handle handle(system, file);
      const auto name = camera_name(handle);
      if (!name) continue;
      listing.name = *name;
      for (const std::uint32_t code : formats_of(handle)) add_modes(handle, code, listing.modes);
    } catch (const Error& error) {
      listing.problem = error.what();
    }
    list.push_back(std::move(listing));
  }
  return list;
}

}  // namespace rastro

#else

namespace rastro {

std::unique_ptr<LiveSource> open_v4l2(const std::string& address, const std::string&, const OpenOptions&, V4l2System&,
                                      Clock&) {
  throw Error("this build does not read cameras of Video4Linux2", address, "build with -DRASTRO_WITH_V4L2=ON");
}

std::vector<V4l2Listing> list_v4l2(V4l2System&) { return {}; }

}  // namespace rastro

#endif
