// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/rosbag/rosbag.h"

#include <fstream>

#include "rastro/base/error.h"
#include "rastro/dataset/folder.h"

#if RASTRO_WITH_ROSBAG

#include <fmt/format.h>

#include "rastro/dataset/calibration.h"
#include "rastro/dataset/recording.h"
#include "rastro/dataset/rosbag/bag_contents.h"
#include "rastro/dataset/rosbag/bag_messages.h"
#include "rastro/dataset/rosbag/bag_stream.h"
#include "rastro/dataset/rosbag/bag_topics.h"

namespace rastro {
namespace {

constexpr double units_per_meter = 1000.0;  ///< REP 118; depth as float is in meters.

class BagSource final : public Source {
 public:
  BagSource(const std::string& path, const OpenOptions& options) : options_(options) {
    info_.path = path;
    const BagContents contents = read_bag_contents(path);
    std::int64_t messages = 0;
    for (const auto& [topic, count] : contents.message_count) messages += count;
    if (messages == 0) throw Error("has no complete message", path, "");
    if (!contents.has_index)
      info_.warnings.push_back(
          fmt::format("the bag was not closed or is truncated: its {} complete messages are read: {}", messages, path));
    topics_ = choose_topics(contents, options, info_);
    describe(contents);
    choice_ = FrameChoice(options, info_.frame_count, path);
    const bool with_depth = options.want_depth && !topics_.depth.empty();
    if (auto warning = with_depth ? sparse_depth_warning(topics_, path) : ""; !warning.empty())
      info_.warnings.push_back(std::move(warning));
    stream_.emplace(path, std::set<std::string>{topics_.main(), topics_.odometry, topics_.imu},
                    with_depth ? topics_.depth : "");
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (position_ >= choice_.count) return std::nullopt;
    const std::int64_t wanted = choice_.index(position_++);
    while (auto message = stream_->next()) {
      if (message->topic == topics_.odometry) keep_odometry(*message);
      if (message->topic == topics_.imu) keep_imu(*message);
      if (message->topic == topics_.main() && at_++ >= wanted) return make_frame(wanted, *message);
    }
    return std::nullopt;
  }

 private:
  void describe(const BagContents& contents) {
    info_.format = "rosbag";
    info_.has_scan = !topics_.scan.empty();
    info_.has_image = !info_.has_scan;
    info_.has_odometry = !topics_.odometry.empty();
    info_.has_imu = !topics_.imu.empty();
    if (!topics_.depth.empty()) {
      if (options_.want_depth) readings_ = depth_readings(options_, units_per_meter);
      describe_depth(readings_, info_);
    }
    info_.frame_count = contents.message_count.at(topics_.main());
    const auto images = topics_of(contents, "sensor_msgs/Image");
    if (info_.has_scan && !images.empty())
      info_.warnings.push_back(fmt::format("the frames are the scans of {}; --camera TOPIC gives the images of {}",
                                           topics_.scan, fmt::join(images, " or ")));
    if (info_.has_scan) return;
    info_.cameras.push_back(camera_of_topic(topics_, contents, info_));
    finish_calibration(info_, options_, size_of_images(topics_, contents));
  }

  std::string where_of(const BagMessage& message) const {
    return fmt::format("{}, topic {}, time {:.6f}", info_.path, message.topic, to_seconds(message.time));
  }

  void keep_odometry(const BagMessage& message) {
    try {
      odometry_ = pose_of(decode<OdometryMessage>(message, info_.path), info_.path);
    } catch (const Error&) {
      odometry_.reset();  // An older pose would be a lie.
    }
  }

  void keep_imu(const BagMessage& message) {
    try {
      imu_.push_back(sample_of(decode<ImuMessage>(message, info_.path)));
    } catch (const Error&) {
      // One reading of hundreds a second: the next one says nearly the same.
    }
  }

  Frame make_frame(std::int64_t index, const BagMessage& message) {
    Frame frame;
    frame.index = index;
    frame.name = fmt::format("frame {}", index);
    frame.stamp = stamp_of(message);
    frame.odometry_from_body = odometry_;
    frame.imu = std::move(imu_);
    imu_.clear();
    const auto where = where_of(message);
    if (!topics_.scan.empty()) {
      frame.scan = scan_of(decode<ScanMessage>(message, where), where);
    } else if (!topics_.image.empty()) {
      keep_image(frame, image_of(decode<ImageMessage>(message, where), options_.want_color, where), where);
    } else {
      keep_image(frame, image_of(decode<CompressedMessage>(message, where), options_.want_color, where), where);
    }
    if (!topics_.depth.empty() && options_.want_depth) add_depth(frame, message.time);
    return frame;
  }

  void keep_image(Frame& frame, DecodedImage image, const std::string& where) {
    const ImageSize size{image.gray.width(), image.gray.height()};
    if (first_size_.width == 0) first_size_ = size;
    if (first_size_ != size)
      throw UnusableSource(fmt::format("the image is {}x{}, but those before it {}x{}", size.width, size.height,
                                       first_size_.width, first_size_.height),
                           where, "all images of a recording must have one size");
    frame.image = std::move(image.gray);
    frame.color = std::move(image.color);
  }

  void add_depth(Frame& frame, TimeNs recorded) {
    const BagMessage* message = stream_->depth_near(frame.stamp, recorded);
    if (!message) return;
    const auto where = where_of(*message);
    frame.depth = depth_of(*message, where, readings_);
    frame.depth_stamp = stamp_of(*message);
    if (info_.depth_registration || options_.raw_depth) return;
    if (frame.depth.width() != frame.image.width() || frame.depth.height() != frame.image.height())
      throw UnusableSource("the depth image has another size than the image", where, "");
  }

  OpenOptions options_;
  SourceInfo info_;
  std::optional<BagStream> stream_;
  BagTopics topics_;
  FrameChoice choice_;
  ImageSize first_size_;
  std::optional<SE2> odometry_;
  std::vector<ImuSample> imu_;
  DepthReadings readings_;
  std::int64_t at_ = 0;  ///< Number of the next message of the main topic.
  std::int64_t position_ = 0;
};

}  // namespace

std::unique_ptr<Source> open_rosbag(const std::string& path, const OpenOptions& options) {
  return std::make_unique<BagSource>(path, options);
}

}  // namespace rastro

#else

namespace rastro {

std::unique_ptr<Source> open_rosbag(const std::string& path, const OpenOptions&) {
  throw Error("this build reads no ROS bags", path, "build with -DRASTRO_WITH_ROSBAG=ON");
}

}  // namespace rastro

#endif

namespace rastro {

bool is_rosbag(const std::string& path) {
  if (!is_file(path)) return false;
  if (path.ends_with(".bag")) return true;
  constexpr std::string_view magic = "#ROSBAG V";
  std::string front(magic.size(), '\0');
  std::ifstream(path, std::ios::binary).read(front.data(), static_cast<std::streamsize>(front.size()));
  return front == magic;
}

}  // namespace rastro
