// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/rosbag/rosbag.h"

#include <fstream>

#include "rastro/base/error.h"
#include "rastro/dataset/folder.h"

#if RASTRO_WITH_ROSBAG

#include <fmt/format.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <set>

#include "rastro/base/text.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/recording.h"
#include "rastro/dataset/rosbag/bag_messages.h"

namespace rastro {
namespace {

constexpr TimeNs most_depth_offset = 20'000'000;

/// The topics that are read; empty where there is none.
struct Topics {
  std::string scan, image, compressed, depth, camera_info, odometry, imu;

  const std::string& main() const { return !scan.empty() ? scan : !image.empty() ? image : compressed; }
};

template <typename Message>
std::string where_of(const std::string& path, const std::string& topic, const Message& message) {
  return fmt::format("{}, topic {}, time {}.{:09}", path, topic, message.getTime().sec, message.getTime().nsec);
}

/// What the libraries below throw becomes an Error of one line.
template <typename Action>
auto guarded(const std::string& path, Action action) {
  try {
    return action();
  } catch (const Error&) {
    throw;
  } catch (const rosbag::BagUnindexedException&) {
    throw Error("the bag was never closed: it has no index", path, "'rosbag reindex' makes one");
  } catch (const std::exception& exception) {
    throw Error(fmt::format("the bag cannot be read ({})", one_line(exception.what())), path,
                "it may have been cut short: 'rosbag reindex' saves what is whole");
  }
}

/// Which topics the bag has, by type.
class Contents {
 public:
  explicit Contents(const rosbag::Bag& bag) : bag_(bag) {
    rosbag::View view(bag);
    for (const auto* connection : view.getConnections()) topics_[connection->datatype].insert(connection->topic);
  }

  std::vector<std::string> of(const std::string& type) const {
    const auto found = topics_.find(type);
    if (found == topics_.end()) return {};
    return {found->second.begin(), found->second.end()};
  }

  /// The first topic by name of this type that `wanted` accepts; a warning where others were left.
  template <typename Wanted>
  std::string first(const std::string& type, std::vector<std::string>& warnings, Wanted wanted) const {
    std::vector<std::string> topics = of(type);
    std::erase_if(topics, [&](const std::string& topic) { return !wanted(topic); });
    if (topics.empty()) return "";
    if (topics.size() > 1)
      warnings.push_back(
          fmt::format("topic {} is read, not {}", topics.front(), fmt::join(topics.begin() + 1, topics.end(), ", ")));
    return topics.front();
  }

  template <typename Message>
  boost::shared_ptr<Message> first_message(const std::string& topic) const {
    rosbag::View view(bag_, rosbag::TopicQuery(topic));
    if (view.begin() == view.end()) return nullptr;
    return view.begin()->template instantiate<Message>();
  }

  bool has_depth(const std::string& topic) const {
    const auto message = first_message<ImageMessage>(topic);
    return message && is_depth(*message);
  }

  std::string text() const {
    std::vector<std::string> lines;
    for (const auto& [type, topics] : topics_) lines.push_back(fmt::format("{} ({})", fmt::join(topics, ", "), type));
    return lines.empty() ? "no topics" : one_line(fmt::format("{}", fmt::join(lines, "; ")), 400);
  }

 private:
  const rosbag::Bag& bag_;
  std::map<std::string, std::set<std::string>> topics_;
};

bool any(const std::string&) { return true; }

/// The image topic that --camera names, whichever kind it is.
void choose_camera(Topics& topics, const Contents& contents, const std::string& wanted, const std::string& path) {
  const auto images = contents.of("sensor_msgs/Image"), packed = contents.of("sensor_msgs/CompressedImage");
  if (std::find(images.begin(), images.end(), wanted) != images.end()) {
    topics.image = wanted;
  } else if (std::find(packed.begin(), packed.end(), wanted) != packed.end()) {
    topics.compressed = wanted;
  } else {
    throw Error(fmt::format("there is no image topic {}", in_quotes(wanted)), path, "it has " + contents.text());
  }
}

Topics choose_topics(const Contents& contents, const OpenOptions& options, SourceInfo& info) {
  auto& warnings = info.warnings;
  Topics topics;
  const auto bright = [&](const std::string& topic) { return !contents.has_depth(topic); };
  const auto no_depth = [](const std::string& topic) { return topic.find("epth") == std::string::npos; };
  if (!options.camera.empty()) {
    choose_camera(topics, contents, options.camera, info.path);
  } else {
    topics.scan = contents.first("sensor_msgs/LaserScan", warnings, any);
    if (topics.scan.empty()) topics.image = contents.first("sensor_msgs/Image", warnings, bright);
    if (topics.main().empty()) topics.compressed = contents.first("sensor_msgs/CompressedImage", warnings, no_depth);
  }
  if (topics.main().empty())
    throw Error("holds neither laser scans nor images", info.path, "it has " + contents.text());
  if (topics.scan.empty()) {
    topics.depth = contents.first("sensor_msgs/Image", warnings,
                                  [&](const std::string& topic) { return topic != topics.image && !bright(topic); });
    const std::string folder = topics.main().substr(0, topics.main().rfind('/') + 1);
    topics.camera_info = contents.first("sensor_msgs/CameraInfo", warnings, [&](const std::string& topic) {
      return topic == folder + "camera_info" || topics.compressed.starts_with(topic.substr(0, topic.rfind('/') + 1));
    });
  }
  topics.odometry = contents.first("nav_msgs/Odometry", warnings, any);
  topics.imu = contents.first("sensor_msgs/Imu", warnings, any);
  return topics;
}

class BagSource final : public Source {
 public:
  BagSource(const std::string& path, const OpenOptions& options) : options_(options) {
    info_.path = path;
    guarded(path, [&] {
      bag_.open(path, rosbag::bagmode::Read);
      const Contents contents(bag_);
      topics_ = choose_topics(contents, options, info_);
      describe(contents);
      choice_ = FrameChoice(options, info_.frame_count, path);
      view_.addQuery(bag_, rosbag::TopicQuery(read_topics()));
      message_ = view_.begin();
    });
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (position_ >= choice_.count || broken_) return std::nullopt;
    const std::int64_t wanted = choice_.index(position_++);
    for (; at_end() == false; advance()) {
      const auto& topic = message_->getTopic();
      if (topic == topics_.odometry) keep_odometry();
      if (topic == topics_.imu) keep_imu();
      if (topic == topics_.depth && options_.want_depth) last_depth_ = instantiate<ImageMessage>();
      if (topic != topics_.main() || at_++ < wanted) continue;
      // Left behind before it is decoded, so that reading goes on after a broken message.
      const rosbag::MessageInstance message = *message_;
      advance();
      return make_frame(wanted, message);
    }
    return std::nullopt;
  }

 private:
  void describe(const Contents& contents) {
    info_.format = "rosbag";
    info_.has_scan = !topics_.scan.empty();
    info_.has_image = !info_.has_scan;
    info_.has_odometry = !topics_.odometry.empty();
    info_.has_imu = !topics_.imu.empty();
    info_.has_depth = !topics_.depth.empty();
    info_.depth_factor = info_.has_depth ? 1000.0 : 0.0;
    info_.frame_count = rosbag::View(bag_, rosbag::TopicQuery(topics_.main())).size();
    if (info_.has_scan && !contents.of("sensor_msgs/Image").empty())
      info_.warnings.push_back(fmt::format("the frames are the scans of {}; --camera TOPIC gives the images of {}",
                                           topics_.scan, fmt::join(contents.of("sensor_msgs/Image"), " or ")));
    if (info_.has_scan) return;
    CalibratedCamera& camera = info_.cameras.emplace_back();
    camera.name = topics_.main();
    if (!topics_.camera_info.empty()) {
      const auto message = contents.first_message<CameraMessage>(topics_.camera_info);
      if (message) camera.camera = camera_of(*message, topics_.main().find("rect") != std::string::npos);
      if (camera.camera) camera.calibration_file = topics_.camera_info;
    }
    finish_calibration(info_, options_, std::nullopt);
  }

  std::vector<std::string> read_topics() const {
    std::vector<std::string> topics = {topics_.main()};
    for (const auto& topic : {topics_.odometry, topics_.imu, options_.want_depth ? topics_.depth : std::string()})
      if (!topic.empty()) topics.push_back(topic);
    return topics;
  }

  /// Where the bag itself breaks nothing can follow.
  template <typename Action>
  auto or_break(Action action) {
    try {
      return guarded(info_.path, action);
    } catch (const Error& error) {
      broken_ = true;
      throw UnusableSource(error.what());
    }
  }

  bool at_end() {
    return or_break([&] { return message_ == view_.end(); });
  }
  void advance() {
    or_break([&] { ++message_; });
  }

  /// The current message; nullptr where it is broken, as for what only accompanies a frame.
  template <typename Message>
  boost::shared_ptr<Message> instantiate() {
    try {
      return message_->instantiate<Message>();
    } catch (const std::exception&) {
      return nullptr;
    }
  }

  void keep_odometry() {
    const auto message = instantiate<OdometryMessage>();
    if (!message) return;
    try {
      odometry_ = pose_of(*message, info_.path);
    } catch (const Error&) {
      odometry_.reset();  // An older pose would be a lie.
    }
  }

  void keep_imu() {
    if (const auto message = instantiate<ImuMessage>()) imu_.push_back(sample_of(*message));
  }

  Frame make_frame(std::int64_t index, const rosbag::MessageInstance& message) {
    Frame frame;
    frame.index = index;
    frame.name = fmt::format("frame {}", index);
    frame.odometry_from_body = odometry_;
    frame.imu = std::move(imu_);
    imu_.clear();
    const auto where = where_of(info_.path, topics_.main(), message);
    guarded(where, [&] {
      if (!topics_.scan.empty()) {
        const auto scan = decode<ScanMessage>(message, frame, where);
        frame.scan = scan_of(*scan, where);
      } else if (!topics_.image.empty()) {
        const auto image = decode<ImageMessage>(message, frame, where);
        keep_image(frame, image_of(*image, options_.want_colour, where), where);
      } else {
        const auto image = decode<CompressedMessage>(message, frame, where);
        keep_image(frame, image_of(*image, options_.want_colour, where), where);
      }
      if (!topics_.depth.empty() && options_.want_depth) add_depth(frame, where);
    });
    return frame;
  }

  template <typename Message>
  boost::shared_ptr<Message> decode(const rosbag::MessageInstance& message, Frame& frame, const std::string& where) {
    auto decoded = message.instantiate<Message>();
    if (!decoded) throw Error("the message is of another version of its type", where, "");
    frame.stamp = decoded->header.stamp.isZero() ? nanoseconds(message.getTime()) : nanoseconds(decoded->header.stamp);
    return decoded;
  }

  void keep_image(Frame& frame, DecodedImage image, const std::string& where) {
    const ImageSize size{image.grey.width(), image.grey.height()};
    if (first_size_.width == 0) first_size_ = size;
    if (first_size_ != size)
      throw UnusableSource(fmt::format("the image is {}x{}, but those before it {}x{}", size.width, size.height,
                                       first_size_.width, first_size_.height),
                           where, "all images of a recording must have one size");
    frame.image = std::move(image.grey);
    frame.colour = std::move(image.colour);
  }

  /// The nearest in time of the last depth image before the frame and the first one behind it.
  void add_depth(Frame& frame, const std::string& where) {
    const auto offset = [&](const boost::shared_ptr<ImageMessage>& depth) {
      return depth ? std::abs(nanoseconds(depth->header.stamp) - frame.stamp) : std::numeric_limits<TimeNs>::max();
    };
    const auto following = depth_behind(frame.stamp);
    const auto& nearest = offset(following) < offset(last_depth_) ? following : last_depth_;
    if (offset(nearest) > most_depth_offset) return;
    frame.depth = depth_of(*nearest, where);
    frame.depth_stamp = nanoseconds(nearest->header.stamp);
    if (frame.depth.width() != frame.image.width() || frame.depth.height() != frame.image.height())
      throw UnusableSource("the depth image has another size than the image", where, "");
  }

  /// Looks ahead without moving on.
  boost::shared_ptr<ImageMessage> depth_behind(TimeNs stamp) {
    return or_break([&]() -> boost::shared_ptr<ImageMessage> {
      for (auto ahead = message_; ahead != view_.end(); ++ahead) {
        if (nanoseconds(ahead->getTime()) > stamp + 10 * most_depth_offset) break;
        if (ahead->getTopic() == topics_.depth) return ahead->instantiate<ImageMessage>();
      }
      return nullptr;
    });
  }

  OpenOptions options_;
  SourceInfo info_;
  rosbag::Bag bag_;
  rosbag::View view_;
  rosbag::View::iterator message_;
  Topics topics_;
  FrameChoice choice_;
  ImageSize first_size_;
  std::optional<SE2> odometry_;
  std::vector<ImuSample> imu_;
  boost::shared_ptr<ImageMessage> last_depth_;
  std::int64_t at_ = 0;  ///< Number of the next message of the main topic.
  std::int64_t position_ = 0;
  bool broken_ = false;
};

}  // namespace

std::unique_ptr<Source> open_rosbag(const std::string& path, const OpenOptions& options) {
  // The library would print what it throws as well.
  console_bridge::noOutputHandler();
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
