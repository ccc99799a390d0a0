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

/// A file by its topics.
class TopicFile {
 public:
  TopicFile(const PutPiece& put, const McapFile::Facts& facts, std::size_t chunk_bytes)
      : file_(put, chunk_bytes), schemas_(detail::foxglove_schemas()) {
    file_.add_metadata("rastro", facts);
  }

  /// Of the topics, in the order in which they are asked for.
  std::uint16_t channel_of(const McapTopic& topic, const McapFile::Facts& facts) {
    const auto found = channels_.find(topic.topic);
    if (found != channels_.end()) return found->second;
    const auto [schema, is_new] = schema_ids_.try_emplace(topic.schema);
    if (is_new) schema->second = file_.add_schema(topic.schema, schemas_);
    return channels_[topic.topic] = file_.add_channel(schema->second, topic.topic, facts);
  }
  McapFile& file() { return file_; }

 private:
  McapFile file_;
  std::string schemas_;
  std::map<std::string, std::uint16_t> schema_ids_, channels_;
};

/// Of what a topic shows, for a reader of the file.
McapFile::Facts facts_of_topic(const McapRun& run, const char* time) {
  McapFile::Facts facts{{"time", time}};
  if (const auto unit = run.facts.find("unit"); unit != run.facts.end()) facts["unit"] = unit->second;
  return facts;
}

/// The messages of a file and their topics.
class McapPlan {
 public:
  explicit McapPlan(const McapRun& run) : run_(run), first_(first_stamp(run)), whole_time_("the first of all") {
    add_whole_run();
    add_frames();
    add_images();
    for (const McapRun::Note& note : run_.notes)
      add("/log", "Log", note.stamp, [&note] { return detail::log_message(note); });
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const PlannedMessage& a, const PlannedMessage& b) { return a.time < b.time; });
  }
  /// Only what the whole run led to, at the time `last`.
  McapPlan(const McapRun& run, TimeNs last) : run_(run), first_(last), whole_time_("the last of all") {
    add_whole_run();
  }

  std::vector<McapTopic> write(const PutPiece& put) const {
    TopicFile file(put, run_.facts, McapFile::default_chunk_bytes);
    write_messages(file);
    file.file().finish();
    return topics();
  }
  void write_messages(TopicFile& file) const {
    std::vector<std::uint16_t> channels;
    for (const PlannedTopic& topic : topics_) channels.push_back(file.channel_of(topic, facts_of(topic)));
    for (const PlannedMessage& message : messages_)
      file.file().add_message(channels[message.topic], message.time, message.make());
  }
  /// By name.
  std::vector<McapTopic> topics() const {
    std::vector<McapTopic> topics(topics_.begin(), topics_.end());
    std::sort(topics.begin(), topics.end(), [](const auto& a, const auto& b) { return a.topic < b.topic; });
    return topics;
  }

 private:
  void add_whole_run() {
    add_paths();
    add_map();
    add_scenes();
  }
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

  McapFile::Facts facts_of(const PlannedTopic& topic) const {
    const std::string whole = std::string(whole_time_) + ": shows the whole run";
    return facts_of_topic(run_, topic.of_whole_run ? whole.c_str() : "of the recording");
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

  void add_paths() {
    add_whole("/tf_static", "FrameTransform", [this] { return detail::upright_message(first_, run_.up); });
    const auto path = [this](const char* topic, const Trajectory& poses) {
      if (!poses.empty())
        add_whole(topic, "PosesInFrame", [this, &poses] { return detail::poses_message(first_, poses); });
    };
    path("/trajectory", run_.trajectory);
    path("/trajectory_online", run_.online);
  }

  void add_frames() {
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
  TimeNs first_;  ///< Of what shows the whole run.
  const char* whole_time_;
  std::vector<PlannedTopic> topics_;
  std::vector<PlannedMessage> messages_;
};

}  // namespace

std::vector<McapTopic> put_mcap(const McapRun& run, const PutPiece& put) { return McapPlan(run).write(put); }

class McapRecorder::State {
 public:
  State(McapRun about, const PutPiece& put) : about_(std::move(about)), file_(put, about_.facts, chunk_bytes) {}

  void add(const char* topic, const char* schema, TimeNs time, const std::string& message) {
    if (time < 0) throw Error(fmt::format("the stamp {} ns is negative", time), "--mcap", "MCAP has no such times");
    if (counts_.empty() && !began_) begin(time);
    last_ = std::max(last_, time);
    const auto [found, is_new] = counts_.try_emplace(topic, McapTopic{topic, std::string("foxglove.") + schema, 0});
    ++found->second.messages;
    file_.file().add_message(file_.channel_of(found->second, facts_of_topic(about_, "of the recording")), time,
                             message);
  }

  std::vector<McapTopic> finish(const McapRun& run) {
    const McapPlan plan(run, last_);
    plan.write_messages(file_);
    file_.file().add_metadata("rastro_result", run.facts);
    file_.file().finish();
    for (const McapTopic& topic : plan.topics()) {
      const auto [found, is_new] = counts_.try_emplace(topic.topic, topic);
      if (!is_new) found->second.messages += topic.messages;
    }
    std::vector<McapTopic> topics;
    for (const auto& [name, topic] : counts_) topics.push_back(topic);
    return topics;
  }

  const McapRun& about() const { return about_; }

 private:
  static constexpr std::size_t chunk_bytes = 64 * 1024;  // what a killed run may lose

  /// Which way is up, before anything is shown.
  void begin(TimeNs time) {
    began_ = true;
    add("/tf_static", "FrameTransform", time, detail::upright_message(time, about_.up));
  }

  McapRun about_;
  TopicFile file_;
  bool began_ = false;
  TimeNs last_ = 0;
  std::map<std::string, McapTopic> counts_;
};

McapRecorder::McapRecorder(McapRun about, PutPiece put)
    : state_(std::make_unique<State>(std::move(about), std::move(put))) {}
McapRecorder::~McapRecorder() = default;

void McapRecorder::add(const StampedPose& pose) {
  state_->add("/tf", "FrameTransform", pose.stamp,
              detail::transform_message(pose.stamp, state_->about(), pose.world_from_body));
  state_->add("/pose", "PoseInFrame", pose.stamp, detail::pose_message(pose.stamp, pose.world_from_body));
}

void McapRecorder::add(const McapRun::Note& note) { state_->add("/log", "Log", note.stamp, detail::log_message(note)); }

void McapRecorder::add_image(TimeNs stamp, const std::string& jpeg) {
  const McapRun& about = state_->about();
  if (about.camera)
    state_->add("/camera/calibration", "CameraCalibration", stamp, detail::calibration_message(stamp, about));
  state_->add("/camera/image", "CompressedImage", stamp, detail::image_message(stamp, about, jpeg));
}

std::vector<McapTopic> McapRecorder::finish(const McapRun& run) { return state_->finish(run); }

}  // namespace rastro
#else
namespace rastro {

std::vector<McapTopic> put_mcap(const McapRun&, const PutPiece&) {
  throw Error("this rastro was built without MCAP", "--to mcap", "build with -DRASTRO_WITH_MCAP=ON");
}

class McapRecorder::State {};
McapRecorder::McapRecorder(McapRun, PutPiece) {
  throw Error("this rastro was built without MCAP", "--mcap", "build with -DRASTRO_WITH_MCAP=ON");
}
McapRecorder::~McapRecorder() = default;
void McapRecorder::add(const StampedPose&) {}
void McapRecorder::add(const McapRun::Note&) {}
void McapRecorder::add_image(TimeNs, const std::string&) {}
std::vector<McapTopic> McapRecorder::finish(const McapRun&) { return {}; }

}  // namespace rastro
#endif
