// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/rosbag/rosbag.h"

#include <fstream>

#include "rastro/base/error.h"
#include "rastro/dataset/folder.h"

#if RASTRO_WITH_ROSBAG

#include <fmt/format.h>

#include <algorithm>
#include <deque>

#include "rastro/base/text.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/recording.h"
#include "rastro/dataset/rosbag/bag_contents.h"
#include "rastro/dataset/rosbag/bag_messages.h"

namespace rastro {
namespace {

constexpr TimeNs most_depth_offset = 20'000'000;
constexpr double units_per_meter = 1000.0;  ///< REP 118; depth as float is in meters.
constexpr TimeNs farthest_look_ahead = 200'000'000;

/// The topics that are read; empty where there is none.
struct Topics {
  std::string scan, image, compressed, depth, camera_info, odometry, imu;

  const std::string& main() const { return !scan.empty() ? scan : !image.empty() ? image : compressed; }
};

template <typename Message>
Message decode(const BagMessage& message, const std::string& where) {
  if (message.md5 != ros::message_traits::MD5Sum<Message>::value())
    throw Error("the message is of another version of " + message.type, where, "");
  Message decoded;
  try {
    ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                       static_cast<std::uint32_t>(message.bytes.size()));
    ros::serialization::deserialize(stream, decoded);
  } catch (const std::exception& exception) {
    throw Error(fmt::format("the message is damaged ({})", one_line(exception.what())), where, "");
  }
  return decoded;
}

std::vector<std::string> topics_of(const BagContents& contents, const std::string& type) {
  const auto found = contents.topics_of_type.find(type);
  if (found == contents.topics_of_type.end()) return {};
  return {found->second.begin(), found->second.end()};
}

std::string text_of(const BagContents& contents) {
  std::vector<std::string> lines;
  for (const auto& [type, topics] : contents.topics_of_type)
    lines.push_back(fmt::format("{} ({})", fmt::join(topics, ", "), type));
  return lines.empty() ? "no topics" : one_line(fmt::format("{}", fmt::join(lines, "; ")), 400);
}

bool is_depth_topic(const BagContents& contents, const std::string& topic) {
  const auto first = contents.first_message.find(topic);
  if (first == contents.first_message.end()) return false;
  try {
    return is_depth(decode<ImageMessage>(first->second, topic));
  } catch (const Error&) {
    return false;
  }
}

/// The first topic by name of this type that `wanted` accepts; a warning where others were left.
template <typename Wanted>
std::string first_topic(const BagContents& contents, const std::string& type, std::vector<std::string>& warnings,
                        Wanted wanted) {
  std::vector<std::string> topics = topics_of(contents, type);
  std::erase_if(topics, [&](const std::string& topic) { return !wanted(topic); });
  if (topics.empty()) return "";
  if (topics.size() > 1)
    warnings.push_back(
        fmt::format("topic {} is read, not {}", topics.front(), fmt::join(topics.begin() + 1, topics.end(), ", ")));
  return topics.front();
}

bool any(const std::string&) { return true; }

/// The image topic that --camera names, whichever kind it is.
void choose_camera(Topics& topics, const BagContents& contents, const std::string& wanted, const std::string& path) {
  const auto images = topics_of(contents, "sensor_msgs/Image"),
             packed = topics_of(contents, "sensor_msgs/CompressedImage");
  if (std::find(images.begin(), images.end(), wanted) != images.end()) {
    topics.image = wanted;
  } else if (std::find(packed.begin(), packed.end(), wanted) != packed.end()) {
    topics.compressed = wanted;
  } else {
    throw Error(fmt::format("there is no image topic {}", in_quotes(wanted)), path, "it has " + text_of(contents));
  }
}

void choose_main(Topics& topics, const BagContents& contents, const OpenOptions& options, SourceInfo& info) {
  if (!options.camera.empty()) return choose_camera(topics, contents, options.camera, info.path);
  const auto bright = [&](const std::string& topic) { return !is_depth_topic(contents, topic); };
  const auto no_depth = [](const std::string& topic) { return topic.find("epth") == std::string::npos; };
  topics.scan = first_topic(contents, "sensor_msgs/LaserScan", info.warnings, any);
  if (topics.scan.empty()) topics.image = first_topic(contents, "sensor_msgs/Image", info.warnings, bright);
  if (topics.main().empty())
    topics.compressed = first_topic(contents, "sensor_msgs/CompressedImage", info.warnings, no_depth);
  if (topics.main().empty())
    throw Error("has neither laser scans nor images", info.path, "it has " + text_of(contents));
}

Topics choose_topics(const BagContents& contents, const OpenOptions& options, SourceInfo& info) {
  Topics topics;
  choose_main(topics, contents, options, info);
  if (topics.scan.empty()) {
    topics.depth = first_topic(contents, "sensor_msgs/Image", info.warnings, [&](const std::string& topic) {
      return topic != topics.image && is_depth_topic(contents, topic);
    });
    const std::string folder = topics.main().substr(0, topics.main().rfind('/') + 1);
    // Packed images stand one level below: /camera/image_raw/compressed.
    topics.camera_info = first_topic(contents, "sensor_msgs/CameraInfo", info.warnings, [&](const std::string& topic) {
      return topic == folder + "camera_info" || topics.compressed.starts_with(topic.substr(0, topic.rfind('/') + 1));
    });
  }
  topics.odometry = first_topic(contents, "nav_msgs/Odometry", info.warnings, any);
  topics.imu = first_topic(contents, "sensor_msgs/Imu", info.warnings, any);
  return topics;
}

CalibratedCamera calibrated_camera(const Topics& topics, const BagContents& contents) {
  CalibratedCamera camera;
  camera.name = topics.main();
  const auto first = contents.first_message.find(topics.camera_info);
  if (first == contents.first_message.end()) return camera;
  const bool rectified = topics.main().find("rect") != std::string::npos;
  try {
    camera.camera = camera_of(decode<CameraMessage>(first->second, topics.camera_info), rectified);
  } catch (const Error&) {
  }
  if (camera.camera) camera.calibration_file = topics.camera_info;
  return camera;
}

class BagSource final : public Source {
 public:
  BagSource(const std::string& path, const OpenOptions& options) : options_(options), records_(path) {
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
    for (const auto& topic :
         {topics_.main(), topics_.odometry, topics_.imu, options.want_depth ? topics_.depth : std::string()})
      if (!topic.empty()) read_topics_.insert(topic);
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (position_ >= choice_.count) return std::nullopt;
    const std::int64_t wanted = choice_.index(position_++);
    while (auto message = next_message()) {
      if (message->topic == topics_.odometry) keep_odometry(*message);
      if (message->topic == topics_.imu) keep_imu(*message);
      if (message->topic == topics_.depth)
        last_depth_ = std::move(*message);
      else if (message->topic == topics_.main() && at_++ >= wanted)
        return make_frame(wanted, *message);
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
    info_.cameras.push_back(calibrated_camera(topics_, contents));
    finish_calibration(info_, options_, std::nullopt);
  }

  /// From those looked at ahead, then from the bag.
  std::optional<BagMessage> next_message() {
    if (ahead_.empty()) return read_message();
    auto message = std::move(ahead_.front());
    ahead_.pop_front();
    return message;
  }

  std::optional<BagMessage> read_message() {
    while (auto message = records_.next())
      if (read_topics_.count(message->topic) > 0) return message;
    return std::nullopt;
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
    frame.stamp = message.time;
    frame.odometry_from_body = odometry_;
    frame.imu = std::move(imu_);
    imu_.clear();
    const auto where = where_of(message);
    if (!topics_.scan.empty()) {
      const auto scan = decode<ScanMessage>(message, where);
      keep_stamp(frame, scan.header.stamp);
      frame.scan = scan_of(scan, where);
    } else if (!topics_.image.empty()) {
      const auto image = decode<ImageMessage>(message, where);
      keep_stamp(frame, image.header.stamp);
      keep_image(frame, image_of(image, options_.want_color, where), where);
    } else {
      const auto image = decode<CompressedMessage>(message, where);
      keep_stamp(frame, image.header.stamp);
      keep_image(frame, image_of(image, options_.want_color, where), where);
    }
    if (!topics_.depth.empty() && options_.want_depth) add_depth(frame);
    return frame;
  }

  void keep_stamp(Frame& frame, const ros::Time& stamp) {
    if (!stamp.isZero()) frame.stamp = nanoseconds(stamp);
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

  /// The nearest in time of the last depth image before the frame and the first one behind it.
  void add_depth(Frame& frame) {
    std::optional<ImageMessage> nearest;
    std::string where;
    TimeNs best = most_depth_offset;
    const BagMessage* before = last_depth_ ? &*last_depth_ : nullptr;
    for (const BagMessage* message : {before, depth_behind(frame.stamp)}) {
      if (!message) continue;
      auto depth = decode<ImageMessage>(*message, where_of(*message));
      const TimeNs offset = std::abs(nanoseconds(depth.header.stamp) - frame.stamp);
      if (offset > best) continue;
      best = offset;
      nearest = std::move(depth);
      where = where_of(*message);
    }
    if (!nearest) return;
    frame.depth = depth_of(*nearest, where, readings_);
    frame.depth_stamp = nanoseconds(nearest->header.stamp);
    if (info_.depth_registration || options_.raw_depth) return;
    if (frame.depth.width() != frame.image.width() || frame.depth.height() != frame.image.height())
      throw UnusableSource("the depth image has another size than the image", where, "");
  }

  /// Looks ahead in the bag; what was read for it is kept for later.
  const BagMessage* depth_behind(TimeNs stamp) {
    for (std::size_t k = 0;; ++k) {
      if (k == ahead_.size()) {
        auto message = read_message();
        if (!message) return nullptr;
        ahead_.push_back(std::move(*message));
      }
      if (ahead_[k].topic == topics_.depth) return &ahead_[k];
      if (ahead_[k].time > stamp + farthest_look_ahead) return nullptr;
    }
  }

  OpenOptions options_;
  SourceInfo info_;
  BagRecords records_;
  std::set<std::string> read_topics_;
  std::deque<BagMessage> ahead_;
  Topics topics_;
  FrameChoice choice_;
  ImageSize first_size_;
  std::optional<SE2> odometry_;
  std::vector<ImuSample> imu_;
  DepthReadings readings_;
  std::optional<BagMessage> last_depth_;
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
