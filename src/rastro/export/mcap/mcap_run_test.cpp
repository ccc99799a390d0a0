// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/mcap/mcap_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/export/mcap/mcap_reader_testing.h"

#if RASTRO_WITH_MCAP
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/text_format.h>

namespace rastro {
namespace {

using google::protobuf::Message;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr TimeNs second = 1'000'000'000;

/// A short run with one of everything: from 5 s on, with a keyframe at each of its two poses.
McapRun small_run() {
  McapRun run;
  run.facts = {{"name", "room"}, {"unit", "meters"}};
  const SE3 turned(SO3::exp({0.1, -0.2, 0.3}), {1.0 / 3.0, -2.0 / 7.0, 1e-9});
  run.trajectory = {{5 * second, SE3()}, {6 * second + 7, turned}};
  run.online = {{5 * second, SE3()}};
  run.truth = {Eigen::Vector3d::Zero(), {0.3, -0.3, 0.0}};
  run.notes = {{5 * second, McapRun::Level::info, "tracking", "first_frame"},
               {6 * second + 7, McapRun::Level::error, "lost", "few\ninliers"}};
  run.keyframes = {{"0", run.trajectory[0]}, {"1", run.trajectory[1]}};
  run.edges = {{"odometry", {{0, 1}}}, {"loops", {{1, 0}}}};
  run.points = {{"cloud", {1, 2, 3, 4, 5, 6}, {255, 128, 0, 1, 2, 3}, {0.5F, NAN}}, {"landmarks", {7, 8, 9}, {}, {}}};
  run.grids = {{"grid", 3, 2, 0.05, {-1.0, -2.0}, {0, 1, 2, 253, 254, 255}}};
  run.ellipsoids = {{"pose_covariances",
                     {Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()},
                     {Eigen::Matrix3d::Zero(), Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal()}}};
  run.camera = Camera{640, 480, 500.0, 501.0, 320.0, 240.0, Distortion::radial_tangential, {0.1, 0.2, 0.3, 0.4, 0.5}};
  run.images = {{6 * second + 7, [] { return std::string("\xff\xd8jpeg"); }}};
  return run;
}

std::string bytes_of(const McapRun& run) {
  std::string bytes;
  put_mcap(run, [&bytes](std::string_view piece) { bytes += piece; });
  return bytes;
}

/// Decodes messages by nothing but the schemas in the file, as any program does that reads it.
class DecodedFile {
 public:
  explicit DecodedFile(const McapRun& run) : bytes_(bytes_of(run)), file_(bytes_) {
    for (const auto& [id, schema] : file_.schemas) {
      google::protobuf::FileDescriptorSet set;
      EXPECT_TRUE(set.ParseFromString(schema.data));
      for (const auto& each : set.file())
        if (!pool_.FindFileByName(each.name())) EXPECT_NE(pool_.BuildFile(each), nullptr) << each.name();
      EXPECT_NE(pool_.FindMessageTypeByName(schema.name), nullptr) << schema.name;
    }
  }
  const McapFileRead& file() const { return file_; }

  /// The k-th message of a topic as text: one line.
  std::string text(const std::string& topic, std::size_t k = 0) {
    const auto messages = file_.of_topic(topic);
    if (k >= messages.size()) return "none";
    const auto* type = pool_.FindMessageTypeByName(messages[k].schema);
    const std::unique_ptr<Message> message(factory_.GetPrototype(type)->New());
    EXPECT_TRUE(message->ParseFromArray(messages[k].data.data(), static_cast<int>(messages[k].data.size())));
    std::string text;
    google::protobuf::TextFormat::Printer printer;
    printer.SetSingleLineMode(true);
    printer.PrintToString(*message, &text);
    return text;
  }

 private:
  std::string bytes_;
  McapFileRead file_;
  google::protobuf::DescriptorPool pool_;
  google::protobuf::DynamicMessageFactory factory_;
};

/// The number after the n-th `name: ` in a text.
double number_in(const std::string& text, const std::string& name, int n = 0) {
  std::size_t at = 0;
  for (int k = 0; k <= n; ++k) at = text.find(" " + name + ": ", at + 1);
  return at == std::string::npos ? NAN : std::stod(text.substr(at + name.size() + 3));
}

TEST(McapRun, HasATopicForEachThing) {
  std::map<std::string, std::string> topics;
  std::map<std::string, std::uint64_t> counts;
  for (const McapTopic& topic : put_mcap(small_run(), [](std::string_view) {})) {
    topics[topic.topic] = topic.schema;
    counts[topic.topic] = topic.messages;
  }
  EXPECT_EQ(topics, (std::map<std::string, std::string>{{"/camera/calibration", "foxglove.CameraCalibration"},
                                                        {"/camera/image", "foxglove.CompressedImage"},
                                                        {"/cloud", "foxglove.PointCloud"},
                                                        {"/covariances", "foxglove.SceneUpdate"},
                                                        {"/graph", "foxglove.SceneUpdate"},
                                                        {"/grid", "foxglove.Grid"},
                                                        {"/ground_truth", "foxglove.SceneUpdate"},
                                                        {"/keyframes", "foxglove.SceneUpdate"},
                                                        {"/landmarks", "foxglove.PointCloud"},
                                                        {"/log", "foxglove.Log"},
                                                        {"/pose", "foxglove.PoseInFrame"},
                                                        {"/tf", "foxglove.FrameTransform"},
                                                        {"/tf_static", "foxglove.FrameTransform"},
                                                        {"/trajectory", "foxglove.PosesInFrame"},
                                                        {"/trajectory_online", "foxglove.PosesInFrame"}}));
  const DecodedFile decoded(small_run());
  for (const auto& [topic, count] : counts) EXPECT_EQ(decoded.file().of_topic(topic).size(), count) << topic;
  EXPECT_EQ(decoded.file().metadata.at("rastro").at("name"), "room");
}

/// What a run hands over while it goes on.
void record_frames(const McapRun& run, McapRecorder& recorder) {
  for (const StampedPose& pose : run.trajectory) recorder.add(pose);
  for (const McapRun::Note& note : run.notes) recorder.add(note);
  for (const McapRun::Image& image : run.images) recorder.add_image(image.stamp, image.jpeg());
}

TEST(McapRecorder, GivesTheTopicsOfAWholeRun) {
  const McapRun run = small_run();
  std::string bytes;
  McapRecorder recorder(run, [&bytes](std::string_view piece) { bytes += piece; });
  record_frames(run, recorder);
  const std::vector<McapTopic> topics = recorder.finish(run);
  std::map<std::string, std::uint64_t> at_once;
  for (const McapTopic& topic : put_mcap(run, [](std::string_view) {})) at_once[topic.topic] = topic.messages;
  ++at_once["/tf_static"];  // before the first frame, and as the map has it
  const McapFileRead file(bytes);
  std::map<std::string, std::uint64_t> counts;
  for (const McapTopic& topic : topics) {
    counts[topic.topic] = topic.messages;
    EXPECT_EQ(file.of_topic(topic.topic).size(), topic.messages) << topic.topic;
  }
  EXPECT_EQ(counts, at_once);
  EXPECT_EQ(file.of_topic("/cloud").front().time, 6U * second + 7) << "when it was known";
  EXPECT_EQ(file.metadata.at("rastro").at("name"), "room");
}

TEST(McapRecorder, AKilledRunKeepsItsChunks) {
  constexpr std::uint64_t poses = 3000;
  std::string bytes;
  McapRecorder recorder(small_run(), [&bytes](std::string_view piece) { bytes += piece; });
  for (std::uint64_t k = 0; k < poses; ++k) recorder.add({static_cast<TimeNs>(k) * second, SE3()});
  const McapFileRead file(bytes + "12345678");  // in place of the end that a whole file has
  EXPECT_GT(file.of_topic("/pose").size(), 0.8 * poses);
  EXPECT_LE(file.of_topic("/pose").size(), poses);
}

TEST(McapRecorder, RefusesStampsBeforeZero) {
  McapRecorder recorder(small_run(), [](std::string_view) {});
  EXPECT_THROW(recorder.add({-1, SE3()}), Error);
}

TEST(McapRun, LogsAtTheTimesOfTheRecording) {
  const DecodedFile decoded(small_run());
  const McapFileRead& file = decoded.file();
  EXPECT_EQ(file.of_topic("/pose")[0].time, 5'000'000'000U);
  EXPECT_EQ(file.of_topic("/pose")[1].time, 6'000'000'007U);
  EXPECT_EQ(file.of_topic("/camera/image")[0].time, 6'000'000'007U);
  for (const char* topic : {"/trajectory", "/cloud", "/grid", "/graph", "/tf_static"})
    EXPECT_EQ(file.of_topic(topic)[0].time, 5'000'000'000U) << topic << " is there from the first moment on";
  for (std::size_t k = 1; k < file.messages.size(); ++k) EXPECT_LE(file.messages[k - 1].time, file.messages[k].time);
}

TEST(McapRun, PosesHaveEveryDigit) {
  const McapRun run = small_run();
  DecodedFile decoded(run);
  const SE3& pose = run.trajectory[1].world_from_body;
  for (const char* topic : {"/pose", "/tf"}) {
    const std::string text = decoded.text(topic, 1);
    EXPECT_THAT(text, HasSubstr("timestamp { seconds: 6 nanos: 7 }"));
    EXPECT_NEAR(number_in(text, "x"), pose.translation().x(), 1e-15) << text;
    EXPECT_NEAR(number_in(text, "z"), pose.translation().z(), 1e-15);
    EXPECT_NEAR(number_in(text, "w"), pose.rotation().quaternion().w(), 1e-15);
  }
  EXPECT_THAT(decoded.text("/tf", 1), HasSubstr(R"(parent_frame_id: "world" child_frame_id: "camera")"));
  EXPECT_THAT(decoded.text("/pose"), HasSubstr(R"(frame_id: "world")"));
}

TEST(McapRun, TheUprightFrameHasZUp) {
  DecodedFile decoded(small_run());  // up is -y
  const std::string text = decoded.text("/tf_static");
  EXPECT_THAT(text, HasSubstr(R"(parent_frame_id: "upright" child_frame_id: "world")"));
  const Eigen::Quaterniond rotation(number_in(text, "w"), number_in(text, "x"), 0.0, 0.0);
  EXPECT_TRUE((rotation * -Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d::UnitZ(), 1e-9)) << text;
}

TEST(McapRun, PointsArePacked) {
  DecodedFile decoded(small_run());
  const std::string cloud = decoded.text("/cloud");
  EXPECT_THAT(cloud, HasSubstr("point_stride: 20"));
  EXPECT_THAT(cloud, HasSubstr(R"(fields { name: "alpha" offset: 15 type: UINT8 })"));
  EXPECT_THAT(cloud, HasSubstr(R"(fields { name: "sigma" offset: 16 type: FLOAT32 })"));
  EXPECT_THAT(cloud, HasSubstr(R"(\000\000\200?\000\000\000@\000\000@@\377\200\000\377\000\000\000?)"))
      << "1 2 3, color, 0.5";
  EXPECT_THAT(decoded.text("/landmarks"), HasSubstr("point_stride: 12"));
}

TEST(McapRun, GridsAreRowsFromTheSmallestCorner) {
  DecodedFile decoded(small_run());
  const std::string grid = decoded.text("/grid");
  EXPECT_THAT(grid, HasSubstr("position { x: -1 y: -2 }"));
  EXPECT_THAT(grid, HasSubstr("column_count: 3 cell_size { x: 0.05 y: 0.05 } row_stride: 3 cell_stride: 1"));
  EXPECT_THAT(grid, HasSubstr(R"(data: "\000\001\002\375\376\377")"));
}

TEST(McapRun, ImagesHaveTheirCalibration) {
  DecodedFile decoded(small_run());
  EXPECT_THAT(decoded.text("/camera/image"), HasSubstr(R"(data: "\377\330jpeg" format: "jpeg" frame_id: "camera")"));
  const std::string calibration = decoded.text("/camera/calibration");
  EXPECT_THAT(calibration, HasSubstr(R"(width: 640 height: 480 distortion_model: "plumb_bob" D: 0.1 D: 0.2)"));
  EXPECT_THAT(calibration, HasSubstr("K: 500 K: 0 K: 320 K: 0 K: 501 K: 240 K: 0 K: 0 K: 1 R: 1"));
}

TEST(McapRun, NotesHaveTheirLevels) {
  DecodedFile decoded(small_run());
  EXPECT_THAT(decoded.text("/log"), HasSubstr(R"(level: INFO message: "tracking: first_frame" name: "tracking")"));
  EXPECT_THAT(decoded.text("/log", 1), HasSubstr("level: ERROR"));
  EXPECT_THAT(decoded.text("/log", 1), HasSubstr("lost: few")) << "on one line";
}

TEST(McapRun, ScenesHaveKeyframesEdgesAndEllipsoids) {
  DecodedFile decoded(small_run());
  EXPECT_THAT(decoded.text("/keyframes"),
              HasSubstr(R"(id: "keyframe 1" metadata { key: "stamp_ns" value: "6000000007" })"));
  const std::string graph = decoded.text("/graph");
  EXPECT_THAT(graph, HasSubstr(R"(id: "odometry")"));
  EXPECT_THAT(graph, HasSubstr(R"(id: "loops")"));
  const std::string covariances = decoded.text("/covariances");
  EXPECT_EQ(covariances.find("spheres"), covariances.rfind("spheres")) << "the pose that is certain has none";
  const std::size_t size = covariances.find("size {");
  EXPECT_NEAR(number_in(covariances.substr(size), "x"), 0.2, 1e-9) << "diameters by their lengths";
  EXPECT_NEAR(number_in(covariances.substr(size), "z"), 0.6, 1e-9);
}

TEST(McapRun, PlanarRunsMoveABody) {
  McapRun run;
  run.of_camera = false;
  run.up = Eigen::Vector3d::UnitZ();
  run.trajectory = {{second, SE3()}};
  run.keyframes = {{"0", run.trajectory[0]}};
  DecodedFile decoded(run);
  EXPECT_THAT(decoded.text("/tf"), HasSubstr(R"(child_frame_id: "body")"));
  EXPECT_THAT(decoded.text("/keyframes"), HasSubstr("LINE_LIST"));
  EXPECT_EQ(decoded.text("/camera/image"), "none");
}

TEST(McapRun, SameRunGivesSameBytes) { EXPECT_EQ(bytes_of(small_run()), bytes_of(small_run())); }

TEST(McapRun, NoTimeIsNegative) {
  McapRun run = small_run();
  run.trajectory.front().stamp = -1;
  EXPECT_THROW(bytes_of(run), Error);
}

TEST(McapRun, EmptyRunsAreSoundFiles) { EXPECT_EQ(McapFileRead(bytes_of({})).messages.size(), 1U); }

}  // namespace
}  // namespace rastro
#else
namespace rastro {
namespace {

TEST(McapRun, SaysThatItIsNotInThisBuild) {
  EXPECT_THROW(put_mcap({}, [](std::string_view) {}), Error);
}

}  // namespace
}  // namespace rastro
#endif
