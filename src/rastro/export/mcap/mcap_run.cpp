// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/mcap/mcap_run.h"

#include <algorithm>

#include "rastro/base/error.h"
#if RASTRO_WITH_MCAP
#include <fmt/format.h>

#include <limits>

#include "rastro/export/mcap/foxglove_messages.h"
#include "rastro/export/mcap/mcap_file.h"

namespace rastro {
namespace {

struct PlannedTopic : McapTopic {
  bool of_whole_run = false;
};

/// What is to be written, made when its turn comes.
struct PlannedMessage {
  TimeNs time = 0;
  std::size_t topic = 0;
  std::function<std::string()> make;
};

/// The messages of a file and their topics.
class McapPlan {
 public:
  explicit McapPlan(const McapRun& run) : run_(run), first_(first_stamp(run)) {
    add_poses();
    add_map();
    add_scenes();
    add_images();
    for (const McapRun::Note& note : run_.notes)
      add("/log", "Log", note.stamp, [&note] { return detail::log_message(note); });
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const PlannedMessage& a, const PlannedMessage& b) { return a.time < b.time; });
  }

  std::vector<McapTopic> write(const PutPiece& put) const {
    McapFile file(put);
    file.add_metadata("rastro", run_.facts);
    const std::string schemas = detail::foxglove_schemas();
    std::map<std::string, std::uint16_t> schema_ids;
    std::vector<std::uint16_t> channels;
    for (const PlannedTopic& topic : topics_) {
      const auto [found, is_new] = schema_ids.try_emplace(topic.schema);
      if (is_new) found->second = file.add_schema(topic.schema, schemas);
      channels.push_back(file.add_channel(found->second, topic.topic, facts_of(topic)));
    }
    for (const PlannedMessage& message : messages_)
      file.add_message(channels[message.topic], message.time, message.make());
    file.finish();
    std::vector<McapTopic> topics(topics_.begin(), topics_.end());
    std::sort(topics.begin(), topics.end(), [](const auto& a, const auto& b) { return a.topic < b.topic; });
    return topics;
  }

 private:
  static TimeNs first_stamp(const McapRun& run) {
    TimeNs first = std::numeric_limits<TimeNs>::max();
    const auto include = [&first](TimeNs stamp) { first = std::min(first, stamp); };
    for (const Trajectory* trajectory : {&run.trajectory, &run.online})
      for (const StampedPose& pose : *trajectory) include(pose.stamp);
    for (const auto& note : run.notes) include(note.stamp);
    for (const auto& keyframe : run.keyframes) include(keyframe.pose.stamp);
    for (const auto& image : run.images) include(image.stamp);
    if (first == std::numeric_limits<TimeNs>::max()) return 0;
    if (first < 0)
      throw Error(fmt::format("the stamp {} ns is negative", first), "--to mcap", "MCAP has no such times");
    return first;
  }

  /// Of what a topic shows, for a reader of the file.
  McapFile::Facts facts_of(const PlannedTopic& topic) const {
    McapFile::Facts facts{{"time", topic.of_whole_run ? "the first of all: shows the whole run" : "of the recording"}};
    if (const auto unit = run_.facts.find("unit"); unit != run_.facts.end()) facts["unit"] = unit->second;
    return facts;
  }

  std::size_t topic_of(const std::string& topic, const char* schema, bool of_whole_run) {
    const auto found =
        std::find_if(topics_.begin(), topics_.end(), [&](const auto& each) { return each.topic == topic; });
    if (found != topics_.end()) return static_cast<std::size_t>(found - topics_.begin());
    topics_.push_back({{topic, std::string("foxglove.") + schema, 0}, of_whole_run});
    return topics_.size() - 1;
  }

  void add(const std::string& topic, const char* schema, TimeNs time, std::function<std::string()> make,
           bool of_whole_run = false) {
    const std::size_t row = topic_of(topic, schema, of_whole_run);
    ++topics_[row].messages;
    messages_.push_back({time, row, std::move(make)});
  }
  void add_whole(const std::string& topic, const char* schema, std::function<std::string()> make) {
    add(topic, schema, first_, std::move(make), true);
  }

  void add_poses() {
    add_whole("/tf_static", "FrameTransform", [this] { return detail::upright_message(first_, run_.up); });
    const auto path = [this](const char* topic, const Trajectory& poses) {
      if (!poses.empty())
        add_whole(topic, "PosesInFrame", [this, &poses] { return detail::poses_message(first_, poses); });
    };
    path("/trajectory", run_.trajectory);
    path("/trajectory_online", run_.online);
    for (const StampedPose& pose : run_.trajectory) {
      add("/tf", "FrameTransform", pose.stamp,
          [this, &pose] { return detail::transform_message(pose.stamp, run_, pose.world_from_body); });
      add("/pose", "PoseInFrame", pose.stamp,
          [&pose] { return detail::pose_message(pose.stamp, pose.world_from_body); });
    }
  }

  void add_map() {
    for (const McapRun::Points& points : run_.points)
      add_whole("/" + points.name, "PointCloud", [this, &points] { return detail::points_message(first_, points); });
    for (const McapRun::Grid& grid : run_.grids)
      add_whole("/" + grid.name, "Grid", [this, &grid] { return detail::grid_message(first_, grid); });
  }

  void add_scenes() {
    const auto scene = [this](const char* topic, bool is_there, std::string (*make)(TimeNs, const McapRun&)) {
      if (is_there) add_whole(topic, "SceneUpdate", [this, make] { return make(first_, run_); });
    };
    scene("/keyframes", !run_.keyframes.empty(), detail::keyframes_message);
    scene("/graph", !run_.edges.empty(), detail::graph_message);
    scene("/covariances", !run_.ellipsoids.empty(), detail::covariances_message);
    if (!run_.truth.empty())
      add_whole("/ground_truth", "SceneUpdate",
                [this] { return detail::path_message(first_, "ground truth", run_.truth); });
  }

  void add_images() {
    for (const McapRun::Image& image : run_.images) {
      if (run_.camera)
        add("/camera/calibration", "CameraCalibration", image.stamp,
            [this, &image] { return detail::calibration_message(image.stamp, run_); });
      add("/camera/image", "CompressedImage", image.stamp,
          [this, &image] { return detail::image_message(image.stamp, run_, image.jpeg()); });
    }
  }

  const McapRun& run_;
  TimeNs first_;
  std::vector<PlannedTopic> topics_;
  std::vector<PlannedMessage> messages_;
};

}  // namespace

std::vector<McapTopic> put_mcap(const McapRun& run, const PutPiece& put) { return McapPlan(run).write(put); }

}  // namespace rastro
#else
namespace rastro {

std::vector<McapTopic> put_mcap(const McapRun&, const PutPiece&) {
  throw Error("this rastro was built without MCAP", "--to mcap", "build with -DRASTRO_WITH_MCAP=ON");
}

}  // namespace rastro
#endif
