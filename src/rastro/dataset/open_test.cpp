// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/open.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "rastro/base/error.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/folder.h"

namespace rastro {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

OpenOptions everything() {
  OpenOptions options;
  options.want_right = options.want_depth = true;
  return options;
}

std::vector<Frame> read_all(const std::string& path, const OpenOptions& options = everything()) {
  const auto source = open(path, options);
  std::vector<Frame> frames;
  while (auto frame = source->next()) frames.push_back(std::move(*frame));
  return frames;
}

std::vector<std::int64_t> indices(const std::vector<Frame>& frames) {
  std::vector<std::int64_t> result;
  result.reserve(frames.size());
  for (const auto& frame : frames) result.push_back(frame.index);
  return result;
}

std::string open_error(const std::string& path, const OpenOptions& options = {}) {
  return error_of([&] { open(path, options); });
}

TEST(OpenEuroc, ReadsWhicheverFolderIsNamed) {
  const ScratchFolder folder;
  write_euroc(folder, 5, 2);
  for (const char* name : {"", "mav0", "mav0/", "mav0/cam0", "mav0/cam0/"}) {
    const auto source = open(folder.path() + "/" + name, everything());
    EXPECT_EQ(source->info().format, "euroc");
    EXPECT_EQ(source->info().frame_count, 5);
    EXPECT_TRUE(source->info().has_right);
    ASSERT_TRUE(source->info().cameras.front().camera);
    EXPECT_EQ(source->info().cameras.front().camera->fx, 6.0);
    ASSERT_TRUE(source->info().left_from_right);
    EXPECT_NEAR(source->info().left_from_right->translation().x(), 0.1, 1e-12);
    const auto frame = source->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->stamp, 1'400'000'000'000'000'000);
    EXPECT_EQ(frame->image.at(0, 0), 10);
    EXPECT_EQ(frame->right.at(0, 0), 110);
  }
  const auto right = open(folder.path("mav0/cam1"));
  EXPECT_EQ(right->info().cameras.front().name, "cam1");
  EXPECT_EQ(right->next()->image.at(0, 0), 110);
}

TEST(OpenEuroc, ViconPosesAreBroughtToTheBody) {
  const ScratchFolder folder;
  write_euroc(folder, 2);
  folder.write("mav0/vicon0/data.csv", "#t\n1400000000000000000,1,2,3,1,0,0,0\n");
  folder.write("mav0/vicon0/sensor.yaml",
               "%YAML:1.0\nT_BS:\n  data: [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n");
  const auto source = open(folder.path());
  ASSERT_EQ(source->info().ground_truth.size(), 1u);
  EXPECT_NEAR(source->info().ground_truth[0].world_from_body.translation().x(), 0.5, 1e-12);
  EXPECT_EQ(source->info().ground_truth_frame, "body");
}

TEST(OpenTum, PairsDepthAndReadsGroundTruth) {
  const ScratchFolder folder;
  write_tum(folder, 4);
  auto options = everything();
  options.want_color = true;
  const auto source = open(folder.path(), options);
  EXPECT_EQ(source->info().format, "tum_rgbd");
  EXPECT_EQ(source->info().depth_factor, 5000.0);
  EXPECT_EQ(source->info().ground_truth.size(), 4u);
  EXPECT_FALSE(source->info().cameras.front().camera);
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("depth is assumed to have 5000 units per meter")));
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("--fov DEG")));
  source->next();
  const auto frame = source->next();
  EXPECT_EQ(frame->stamp, 1000'050'000'000);
  EXPECT_EQ(frame->depth_stamp, 1000'054'000'000);
  EXPECT_FLOAT_EQ(frame->depth.at(0, 0), 1.001f);
  EXPECT_EQ(frame->color.rgb.at(2, 0), 11);
}

TEST(OpenTum, AssociationsDecideWhereTheyAreThere) {
  const ScratchFolder folder;
  write_tum(folder, 3);
  folder.write("associations.txt", "1000.0 rgb/0.png 1000.104 depth/2.png\n");
  const auto frames = read_all(folder.path());
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_FLOAT_EQ(frames[0].depth.at(0, 0), 1.002f);
  EXPECT_TRUE(frames[1].depth.empty());
}

TEST(OpenTum, MillisecondsAreNoticed) {
  const ScratchFolder folder;
  folder.write_gray("rgb/0.png", 1);
  folder.write("rgb.txt", "1400000000000 rgb/0.png\n1400000000050 rgb/0.png\n1400000000100 rgb/0.png\n");
  const auto source = open(folder.path());
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("stamps look like ms, not s")));
  EXPECT_EQ(source->next()->stamp, 1'400'000'000'000'000'000);
}

TEST(OpenKitti, OdometryWithFewerRightImages) {
  const ScratchFolder folder;
  write_kitti(folder, 4, 2);
  const auto source = open(folder.path(), everything());
  const auto& info = source->info();
  EXPECT_EQ(info.format, "kitti_odometry");
  EXPECT_THAT(info.warnings, Contains("2 of 4 frames have an image in image_1"));
  EXPECT_EQ(info.ground_truth.size(), 4u);
  EXPECT_EQ(info.ground_truth[2].stamp, 100'000'000);
  EXPECT_NEAR(info.left_from_right->translation().x(), 0.5, 1e-12);
  EXPECT_EQ(info.cameras.front().camera->width, 8);
  EXPECT_FALSE(source->next()->right.empty());
  source->next();
  EXPECT_TRUE(source->next()->right.empty());
}

TEST(OpenKitti, OfficialLayoutAndCutClips) {
  const ScratchFolder folder;
  std::string poses, times;
  for (int k = 0; k < 20; ++k) {
    poses += fmt::format("1 0 0 0 0 1 0 0 0 0 1 {}\n", k);
    times += fmt::format("{}\n", 0.1 * k);
  }
  folder.write("poses/07.txt", poses);
  folder.write("sequences/07/times.txt", times);
  for (int k = 10; k < 13; ++k) folder.write_gray(fmt::format("sequences/07/image_0/{:06}.png", k), k);
  const auto source = open(folder.path("sequences/07"));
  ASSERT_EQ(source->info().ground_truth.size(), 3u);
  EXPECT_EQ(source->info().ground_truth[0].world_from_body.translation().z(), 10.0);
  EXPECT_EQ(source->next()->stamp, 1'000'000'000);
}

TEST(OpenKitti, RawDrive) {
  const ScratchFolder folder;
  write_kitti_raw(folder, 3);
  const auto source = open(folder.path());
  EXPECT_EQ(source->info().format, "kitti_raw");
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("oxts/data: has no packets")));
  EXPECT_EQ(source->next()->stamp, 1317042120500000000);
}

TEST(OpenImages, FolderGlobAndOne) {
  const ScratchFolder folder;
  for (const int k : {1, 2, 10}) folder.write_gray(fmt::format("left{}.png", k), k);
  for (const int k : {1, 2}) folder.write_gray(fmt::format("right{}.png", k), 100 + k);
  EXPECT_EQ(read_all(folder.path()).size(), 5u);
  EXPECT_THAT(open(folder.path())->info().warnings, Contains(HasSubstr("the names fall into series (left*, right*)")));
  const auto left = read_all(folder.path("left*.png"));
  ASSERT_EQ(left.size(), 3u);
  EXPECT_EQ(left[2].image.at(0, 0), 10) << "natural order";
  EXPECT_EQ(left[1].stamp, 33333333);
  EXPECT_EQ(read_all(folder.path("left2.png")).size(), 1u);
  OpenOptions options;
  options.rate_hz = 10.0;
  options.field_of_view_deg = 90.0;
  const auto source = open(folder.path("left*"), options);
  EXPECT_FALSE(source->info().has_stamps);
  EXPECT_NEAR(source->info().cameras.front().camera->fx, 4.0, 0.6);
  source->next();
  EXPECT_EQ(source->next()->stamp, 100'000'000);
}

TEST(Open, FramesAreSoughtAndKeepTheirNumbers) {
  const ScratchFolder folder;
  write_euroc(folder, 9);
  OpenOptions other_rate;
  other_rate.rate_hz = 5.0;
  EXPECT_THAT(open(folder.path(), other_rate)->info().warnings, Contains(HasSubstr("those of the recording are used")));
  // Frames that are not chosen are not even opened.
  folder.write("mav0/cam0/data/1400000000050000000.png", "broken");
  OpenOptions options;
  options.first_frame = 2;
  options.end_frame = 8;
  options.every = 3;
  const auto frames = read_all(folder.path(), options);
  EXPECT_THAT(indices(frames), ElementsAre(2, 5));
  EXPECT_EQ(frames[1].image.at(0, 0), 15);
  options.first_frame = 9;
  options.end_frame = 20;
  EXPECT_THAT(open_error(folder.path(), options), AllOf(HasSubstr("--frames"), HasSubstr("frame 9 does not exist")));
}

TEST(Open, OverridesBeatWhatIsFound) {
  const ScratchFolder folder;
  write_euroc(folder, 2);
  folder.write("mav0/cam0/sensor.yaml", "broken: [");
  EXPECT_THAT(open_error(folder.path()), HasSubstr("sensor.yaml"));
  OpenOptions options;
  options.intrinsics = {{7, 7, 4, 3}};
  EXPECT_EQ(open(folder.path(), options)->info().cameras.front().camera->fx, 7.0);
}

TEST(Open, ABrokenFrameIsOneErrorAndReadingGoesOn) {
  for (const int depth : {0, 1, 4}) {
    const ScratchFolder folder;
    write_euroc(folder, 4);
    folder.truncate("mav0/cam0/data/1400000000050000000.png", 0.6);
    std::filesystem::remove(folder.path("mav0/cam0/data/1400000000100000000.png"));
    OpenOptions options;
    options.read_ahead = depth;
    const auto source = open(folder.path(), options);
    EXPECT_EQ(source->next()->index, 0);
    EXPECT_THAT(error_of([&] { source->next(); }), AllOf(HasSubstr("1400000000050000000.png"), HasSubstr("cut short")));
    EXPECT_THAT(error_of([&] { source->next(); }),
                AllOf(HasSubstr("1400000000100000000.png"), HasSubstr("no such file")));
    EXPECT_EQ(source->next()->index, 3);
    EXPECT_FALSE(source->next());
    EXPECT_FALSE(source->next());
  }
}

TEST(Open, ChangingSizeIsAnErrorNamingBoth) {
  const ScratchFolder folder;
  write_euroc(folder, 3);
  folder.write_gray("mav0/cam0/data/1400000000100000000.png", 1, 10, 6);
  const auto source = open(folder.path());
  source->next();
  source->next();
  EXPECT_THROW(
      {
        try {
          source->next();
        } catch (const UnusableSource& error) {
          EXPECT_THAT(error.what(), AllOf(HasSubstr("10x6"), HasSubstr("8x6"), HasSubstr("1400000000100000000.png")));
          throw;
        }
      },
      UnusableSource);
}

TEST(Open, EachBadInputIsOneLineNamingIt) {
  const ScratchFolder folder;
  EXPECT_THAT(open_error(folder.path("none")), AllOf(HasSubstr("none"), HasSubstr("no such file or folder")));
  EXPECT_THAT(open_error(folder.path()), HasSubstr("the folder is empty"));
  folder.write("notes.txt", "x");
  EXPECT_THAT(open_error(folder.path()), HasSubstr("is not a recording of a known format; looked for EuRoC"));
  EXPECT_THAT(open_error(folder.path("notes.txt")), HasSubstr("neither an image nor a video"));
  EXPECT_THAT(open_error(folder.path("*.png")), HasSubstr("no image matches"));
  folder.write("clip.mp4", "no video");
  EXPECT_THAT(open_error(folder.path("clip.mp4")), HasSubstr("clip.mp4"));

  const auto csv = [&](const std::string& text) {
    folder.write("e/mav0/cam0/data.csv", text);
    folder.write_gray("e/mav0/cam0/data/a.png", 1);
    return open_error(folder.path("e"));
  };
  EXPECT_THAT(csv(""), HasSubstr("data.csv: is empty"));
  EXPECT_THAT(csv("#timestamp [ns],filename\n"), HasSubstr("data.csv: lists no image"));
  EXPECT_THAT(csv("#h\n1,a.png\n2,a.png,3\n"), HasSubstr("data.csv:3: 3 columns instead of the 2"));
  EXPECT_THAT(csv("abc,a.png\n"), HasSubstr("data.csv:1: the stamp 'abc' is not a number"));
  EXPECT_THAT(csv("NaN,a.png\n"), HasSubstr("data.csv:1: the stamp 'NaN' is not a number"));
  EXPECT_THAT(csv("5,\n"), HasSubstr("data.csv:1: the file name is missing"));
  EXPECT_THAT(open_error(folder.path()), HasSubstr("is not a recording")) << "e is broken";
  EXPECT_EQ(csv("5,a.png\n"), "");
  EXPECT_THAT(open_error(folder.path()), HasSubstr("did you mean")) << "the recording is one folder below";

  folder.write_gray("k/image_0/000000.png", 1);
  folder.write("k/times.txt", "abc\n");
  EXPECT_THAT(open_error(folder.path("k")), HasSubstr("times.txt:1: the stamp 'abc'"));
  folder.write("t/rgb.txt", "1.0 a.png b.png\n");
  EXPECT_THAT(open_error(folder.path("t")), HasSubstr("rgb.txt:1: 3 columns instead of the 2"));
  OpenOptions camera;
  camera.camera = "cam7";
  EXPECT_THAT(open_error(folder.path("e"), camera), HasSubstr("there is no camera 'cam7'; there are cam0"));
}

TEST(Open, NoPermissionIsSaid) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read everything";
  const ScratchFolder folder;
  write_euroc(folder, 1);
  std::filesystem::permissions(folder.path("mav0/cam0/data.csv"), std::filesystem::perms::none);
  EXPECT_THAT(open_error(folder.path()), HasSubstr("no permission"));
}

TEST(Open, BrokenGroundTruthCostsOnlyTheGroundTruth) {
  const ScratchFolder folder;
  write_tum(folder, 2);
  folder.write("groundtruth.txt", "1000.0 0 0 nan 0 0 0 1\n");
  const auto source = open(folder.path());
  EXPECT_TRUE(source->info().ground_truth.empty());
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("groundtruth.txt:1: column 4 is 'nan'")));
}

}  // namespace
}  // namespace rastro
