// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/pipe.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <variant>

#include "rastro/dataset/live/camera_image.h"
#include "rastro/dataset/live/jpeg_stream.h"
#include "rastro/dataset/live/y4m.h"
#include "rastro/dataset/recording.h"

namespace rastro {
namespace {

constexpr TimeNs first_bytes_within = 10 * ns_per_second;
constexpr std::size_t bytes_at_once = std::size_t{1} << 16;

class PipeDevice final : public CameraDevice {
 public:
  PipeDevice(int descriptor, const OpenOptions& options, const std::atomic<bool>* stop, Clock& clock)
      : descriptor_(descriptor), options_(options), stop_(stop), clock_(clock), offset_(epoch_offset(clock)) {}

  /// Waits for the first bytes and finds what they are. Error where they are neither, or do not come.
  void find_format(const std::string& address) {
    std::array<unsigned char, 2> begin{};
    std::size_t have = 0;
    const TimeNs until = clock_.now() + first_bytes_within;
    while (have < begin.size() && !at_end_ && clock_.now() < until) {
      refuse_if_stopped(address);
      if (wait_for_bytes(ns_per_second / 10)) have += read_some({begin.data() + have, begin.size() - have});
    }
    if (have < begin.size())
      throw Error(at_end_ ? "has no images" : "sends nothing", address,
                  "pipe them in: 'ffmpeg -i FILE -f yuv4mpegpipe - | rastro slam pipe: ...'");
    if (begin[0] == 'Y' && begin[1] == 'U')
      stream_.emplace<Y4mStream>();
    else if (begin[0] != 0xFF || begin[1] != 0xD8)
      throw Error("is neither Y4M nor MJPEG", address, "use 'ffmpeg -i FILE -f yuv4mpegpipe -' or '-f mjpeg -'");
    std::visit([&begin](auto& stream) { stream.feed(begin); }, stream_);
  }

  std::optional<ArrivedFrame> next(TimeNs patience) override {
    const TimeNs until = clock_.now() + patience;
    for (;;) {
      if (auto arrived = take_image()) return arrived;
      if (at_end_) {
        ended_ = true;
        return std::nullopt;
      }
      const TimeNs left = until - clock_.now();
      if (left <= 0 || !wait_for_bytes(left)) return std::nullopt;
      std::array<unsigned char, bytes_at_once> bytes;
      const std::size_t count = read_some(bytes);
      std::visit([&](auto& stream) { stream.feed(std::span(bytes).first(count)); }, stream_);
    }
  }

  bool has_ended() const override { return ended_; }

  void refuse_if_stopped(const std::string& address) const {
    if (stop_ != nullptr && stop_->load()) throw Error("was interrupted before its first image", address, "");
  }

 private:
  bool wait_for_bytes(TimeNs time) const {
    pollfd waiting{descriptor_, POLLIN, 0};
    constexpr TimeNs ns_per_ms = 1'000'000;
    return ::poll(&waiting, 1, static_cast<int>(std::max<TimeNs>(1, time / ns_per_ms))) > 0;
  }

  std::size_t read_some(std::span<unsigned char> into) {
    const ssize_t count = ::read(descriptor_, into.data(), into.size());
    if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) at_end_ = true;
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

  std::optional<ArrivedFrame> take_image() {
    ArrivedFrame arrived;
    const std::int64_t index = images_;
    if (auto* y4m = std::get_if<Y4mStream>(&stream_)) {
      const auto planes = next_planes(*y4m);
      if (!planes) return std::nullopt;
      ++images_;
      convert_y4m(*y4m->header(), *planes, options_.want_color, arrived.frame);
    } else {
      const auto file = std::get<JpegStream>(stream_).next();
      if (!file) return std::nullopt;
      ++images_;
      decode_jpeg(*file, options_.want_color, arrived.frame);
    }
    arrived.exposed = clock_.now();
    arrived.frame.stamp = options_.rate_hz > 0.0 ? made_up_stamp(index, options_.rate_hz) : arrived.exposed + offset_;
    return arrived;
  }

  /// A stream of images without marks to start at again cannot be read on behind damage.
  std::optional<std::span<const unsigned char>> next_planes(Y4mStream& stream) {
    try {
      return stream.next();
    } catch (const Error& error) {
      throw UnusableSource(error.what());
    }
  }

  int descriptor_;
  OpenOptions options_;
  const std::atomic<bool>* stop_;
  Clock& clock_;
  TimeNs offset_;
  std::variant<JpegStream, Y4mStream> stream_;
  std::int64_t images_ = 0;
  bool at_end_ = false;  ///< Of the bytes; images may be left.
  bool ended_ = false;
};

/// A camera whose first image is known, and then all others.
class WithFirst final : public CameraDevice {
 public:
  WithFirst(std::optional<ArrivedFrame> first, std::unique_ptr<CameraDevice> device)
      : first_(std::move(first)), device_(std::move(device)) {}
  std::optional<ArrivedFrame> next(TimeNs patience) override {
    if (!first_) return device_->next(patience);
    auto arrived = std::move(first_);
    first_.reset();
    return arrived;
  }
  bool has_ended() const override { return !first_ && device_->has_ended(); }

 private:
  std::optional<ArrivedFrame> first_;
  std::unique_ptr<CameraDevice> device_;
};

}  // namespace

std::unique_ptr<LiveSource> open_pipe(const std::string& address, int descriptor, const OpenOptions& options,
                                      Clock& clock, const std::atomic<bool>* stop) {
  auto device = std::make_unique<PipeDevice>(descriptor, options, stop, clock);
  device->find_format(address);
  std::optional<ArrivedFrame> first;
  const TimeNs until = clock.now() + first_bytes_within;
  while (!first && !device->has_ended() && clock.now() < until) {
    device->refuse_if_stopped(address);
    first = device->next(ns_per_second / 10);
  }
  if (!first) throw Error("has no whole image", address, "");
  const ImageSize size{first->frame.image.width(), first->frame.image.height()};
  SourceInfo info = camera_info(address, "live_pipe", size, options);
  info.path = "standard input";
  return make_live_camera(std::move(info), std::make_unique<WithFirst>(std::move(first), std::move(device)), {},
                          options, {}, clock);
}

}  // namespace rastro
