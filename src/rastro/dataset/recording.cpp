// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "rastro/base/error.h"

namespace rastro {
namespace {

void require_same_size(const ImageSize& wanted, const ImageSize& found, std::string_view of, const std::string& path) {
  if (wanted == found) return;
  throw UnusableSource(
      fmt::format("the image is {}x{}, but {} {}x{}", found.width, found.height, of, wanted.width, wanted.height), path,
      "all images of a recording must have one size");
}

template <typename T>
ImageSize size_of(const Image<T>& image) {
  return {image.width(), image.height()};
}

class RecordingSource final : public Source {
 public:
  RecordingSource(Recording recording, const OpenOptions& options)
      : recording_(std::move(recording)),
        options_(options),
        choice_(options, static_cast<std::int64_t>(recording_.frames.size()), recording_.info.path) {}

  const SourceInfo& info() const override { return recording_.info; }

  std::optional<Frame> next() override {
    if (position_ >= choice_.count) return std::nullopt;
    // Counted before reading, so that reading goes on behind a broken image.
    const std::int64_t index = choice_.index(position_++);
    return read(index, recording_.frames[static_cast<std::size_t>(index)]);
  }

 private:
  Frame read(std::int64_t index, const RecordedFrame& recorded) {
    Frame frame;
    frame.index = index;
    frame.stamp = recorded.stamp;
    frame.name = std::filesystem::path(recorded.image).filename().string();
    auto image = read_image(recorded.image, options_.want_color);
    if (first_size_.width == 0) first_size_ = size_of(image.gray);
    require_same_size(first_size_, size_of(image.gray), "those before it", recorded.image);
    frame.image = std::move(image.gray);
    frame.color = std::move(image.color);
    if (options_.want_right && !recorded.right.empty()) {
      frame.right = read_image(recorded.right).gray;
      require_same_size(first_size_, size_of(frame.right), "the left one", recorded.right);
    }
    if (options_.want_depth && !recorded.depth.empty()) {
      const SourceInfo& info = recording_.info;
      frame.depth = depth_in_meters(read_raw_depth(recorded.depth), info.depth_factor, info.depth_offset_m);
      frame.depth_stamp = recorded.depth_stamp;
      if (!recording_.info.depth_registration && !options_.raw_depth)
        require_same_size(first_size_, size_of(frame.depth), "the color image", recorded.depth);
    }
    return frame;
  }

  Recording recording_;
  OpenOptions options_;
  FrameChoice choice_;
  ImageSize first_size_;
  std::int64_t position_ = 0;
};

}  // namespace

FrameChoice::FrameChoice(const OpenOptions& options, std::int64_t frame_count, const std::string& path)
    : first(options.first_frame), every(options.every) {
  if (every < 1) throw Error(fmt::format("{} is not a step", every), "--every", "give 1 or more");
  const std::int64_t end = std::min(options.end_frame, frame_count);
  if (first < 0 || first >= options.end_frame) {
    throw Error(fmt::format("{}:{} is an empty range of frames", first, options.end_frame), "--frames",
                "give A:B with 0 <= A < B");
  }
  if (first >= end) {
    throw Error(fmt::format("frame {} does not exist, {} has {}", first, path, frame_count), "--frames",
                "frames count from 0");
  }
  count = (end - first - 1) / every + 1;  // end may be the largest number there is
}

std::unique_ptr<Source> make_recording_source(Recording recording, const OpenOptions& options) {
  return std::make_unique<RecordingSource>(std::move(recording), options);
}

TimeNs made_up_stamp(std::int64_t frame, double rate_hz) {
  return static_cast<TimeNs>(std::llround(static_cast<double>(frame) * 1e9 / rate_hz));
}

}  // namespace rastro
