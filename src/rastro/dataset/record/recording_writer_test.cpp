// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/record/recording_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>

#include "rastro/base/random.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

OpenOptions everything() {
  OpenOptions options;
  options.want_right = options.want_depth = options.want_color = true;
  options.read_ahead = 0;
  return options;
}

template <typename T>
bool same(const Image<T>& a, const Image<T>& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (int y = 0; y < a.height(); ++y)
    if (std::memcmp(a.row(y), b.row(y), static_cast<std::size_t>(a.width()) * sizeof(T)) != 0) return false;
  return true;
}

std::vector<Frame> read_all(Source& source) {
  std::vector<Frame> frames;
  while (auto frame = source.next()) frames.push_back(std::move(*frame));
  return frames;
}

std::vector<Frame> read_all(const std::string& path) { return read_all(*open(path, everything())); }

GrayImage noise(int width, int height, std::uint64_t seed) {
  Random random(seed);
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>(255.0 * random.uniform());
  return image;
}

Frame frame_of(std::int64_t index) {
  Frame frame;
  frame.index = index;
  frame.stamp = 1'700'000'000'123'456'789 + index * 33'333'333;
  frame.image = noise(64, 48, static_cast<std::uint64_t>(index));
  return frame;
}

void copy(const std::string& from, const std::string& to) {
  const auto source = open(from, everything());
  RecordingWriter writer(source->info(), to);
  for (const Frame& frame : read_all(*source)) writer.write(frame);
}

void expect_same(const std::vector<Frame>& a, const std::vector<Frame>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].stamp, b[k].stamp);
    EXPECT_EQ(a[k].depth_stamp, b[k].depth_stamp);
    EXPECT_TRUE(same(a[k].image, b[k].image)) << k;
    EXPECT_TRUE(same(a[k].right, b[k].right)) << k;
    EXPECT_TRUE(same(a[k].color.rgb, b[k].color.rgb)) << k;
    EXPECT_TRUE(same(a[k].depth, b[k].depth)) << k;
  }
}

TEST(RecordingWriter, LosesNothingOfAStereoPairOrOfColorAndDepth) {
  const ScratchFolder folder;
  write_euroc(folder, 4, 2);
  copy(folder.path(), folder.path("euroc"));
  const auto frames = read_all(folder.path("euroc"));
  expect_same(read_all(folder.path()), frames);
  EXPECT_FALSE(frames.front().right.empty());

  const ScratchFolder tum;
  write_tum(tum, 4);
  copy(tum.path(), tum.path("tum"));
  const auto with_depth = read_all(tum.path("tum"));
  expect_same(read_all(tum.path()), with_depth);
  EXPECT_FALSE(with_depth.front().depth.empty());
}

TEST(RecordingWriter, KeepsTheReadingsOfDepthThatACalibrationCorrected) {
  const ScratchFolder folder;
  write_tum(folder, 3);
  folder.write("camera.yaml",
               "image_width: 8\nimage_height: 6\ncamera_matrix: [8, 0, 3.5, 0, 8, 2.5, 0, 0, 1]\n"
               "depth_factor: 4987.3\ndepth_offset_m: -0.0123\n");
  copy(folder.path(), folder.path("copy"));
  const auto frames = read_all(folder.path("copy"));
  ASSERT_GT(frames.front().depth.at(3, 3), 0.0F);
  expect_same(read_all(folder.path()), frames);
}

TEST(RecordingWriter, KeepsStampsTotheNanosecondAlsoIfTheyRepeat) {
  const ScratchFolder folder;
  SourceInfo info;
  info.has_depth = true;
  info.depth_factor = 1000.0;
  std::vector<Frame> frames;
  for (const std::int64_t index : {0, 1, 1, 2, 1, 1}) {
    frames.push_back(frame_of(index));
    frames.back().depth = DepthImage(64, 48);
    frames.back().depth.at(3, 4) = static_cast<float>(1.234 + static_cast<double>(frames.size()));
    frames.back().depth_stamp = frames.back().stamp + 30'000'000;  // nearer to the next image
  }
  {
    RecordingWriter writer(info, folder.path("tum"));
    for (const Frame& frame : frames) writer.write(frame);
  }
  const auto read = read_all(folder.path("tum"));
  ASSERT_EQ(read.size(), frames.size());
  for (std::size_t k = 0; k < read.size(); ++k) {
    EXPECT_EQ(read[k].stamp, frames[k].stamp);
    EXPECT_EQ(read[k].depth_stamp, frames[k].depth_stamp);
    EXPECT_TRUE(same(read[k].image, frames[k].image));
    EXPECT_NEAR(read[k].depth.at(3, 4), frames[k].depth.at(3, 4), 1e-6) << "not the depth of another frame";
  }
}

TEST(RecordingWriter, AStampThatComesAgainLaterOverwritesNoImage) {
  const ScratchFolder folder;
  std::vector<Frame> frames;
  for (const std::int64_t second : {10, 20, 10, 20, 20, 10}) {
    frames.push_back(frame_of(static_cast<std::int64_t>(frames.size())));
    frames.back().right = noise(64, 48, 100 + frames.size());
    frames.back().stamp = 1'700'000'000'000'000'000 + second * ns_per_second;
  }
  {
    RecordingWriter writer({}, folder.path("new"));
    for (const Frame& frame : frames) writer.write(frame);
  }
  const auto read = read_all(folder.path("new"));
  ASSERT_EQ(read.size(), frames.size());
  for (std::size_t k = 0; k < read.size(); ++k) {
    EXPECT_EQ(read[k].stamp, frames[k].stamp);
    EXPECT_TRUE(same(read[k].image, frames[k].image)) << k;
  }
  const auto right_images = std::filesystem::directory_iterator(folder.path("new/mav0/cam1/data"));
  EXPECT_EQ(std::distance(right_images, {}), 6);
}

SourceInfo calibrated_pair(Distortion distortion) {
  SourceInfo info;
  CalibratedCamera left;
  left.camera = Camera{64, 48, 50.1234567890123, 51.0, 31.5, 23.25, distortion, {-0.28, 0.07, 1.5e-4, 2e-5, 0.0}, 0.0};
  if (distortion != Distortion::equidistant) left.camera->coefficients[4] = 0.003;
  if (distortion == Distortion::rational) left.camera->coefficients[7] = -0.02;
  left.body_from_camera = SE3(SO3::exp({0.1, -0.2, 0.3}), {0.01, 0.02, 0.03});
  left.calibration_error = 0.0125;
  left.camera->readout_s = 0.021;
  CalibratedCamera right = left;
  right.camera->fx = 49.5;
  info.cameras = {left, right};
  info.left_from_right = SE3(SO3::exp({0.001, 0.002, -0.003}), {0.11, 0.0, 0.0});
  return info;
}

TEST(RecordingWriter, WritesTheCalibrationThatItReadsBack) {
  for (const Distortion distortion : {Distortion::radial_tangential, Distortion::equidistant, Distortion::rational})
    for (const bool depth : {false, true}) {
      const ScratchFolder folder;
      SourceInfo info = calibrated_pair(distortion);
      info.has_depth = depth;
      RecordingWriter writer(info, folder.path("new"));
      Frame frame = frame_of(0);
      if (!depth) frame.right = frame.image;
      writer.write(frame);
      const SourceInfo read = open(folder.path("new"), everything())->info();
      ASSERT_TRUE(read.cameras.front().camera);
      const Camera &was = *info.cameras.front().camera, &is = *read.cameras.front().camera;
      EXPECT_EQ(std::tie(was.width, was.height, was.fx, was.fy, was.cx, was.cy),
                std::tie(is.width, is.height, is.fx, is.fy, is.cx, is.cy));
      EXPECT_EQ(was.distortion, is.distortion);
      EXPECT_EQ(is.readout_s, 0.021);
      EXPECT_EQ(was.coefficients, is.coefficients);
      EXPECT_EQ(read.cameras.front().calibration_error, 0.0125);
      if (depth) continue;
      EXPECT_EQ(read.cameras.at(1).camera->fx, 49.5);
      const SE3 difference = read.left_from_right->inverse() * *info.left_from_right;
      EXPECT_LT(difference.log().norm(), 1e-12);
    }
}

TEST(RecordingWriter, RefusesFoldersInUseAndSourcesWithoutImages) {
  const ScratchFolder folder;
  SourceInfo laser;
  laser.has_image = false;
  EXPECT_THAT(error_of([&] { RecordingWriter(laser, folder.path("a")); }), HasSubstr("no images"));
  const RecordingWriter writer({}, folder.path("b"));
  EXPECT_THAT(error_of([&] { RecordingWriter({}, folder.path("b")); }), HasSubstr(folder.path("b")));
  folder.write("c/file", "x");
  EXPECT_THAT(error_of([&] { RecordingWriter({}, folder.path("c")); }), HasSubstr("not empty"));
}

/// Writes frames until it is killed; tells the pipe how many are written.
[[noreturn]] void write_until_killed(const std::string& folder, int pipe) {
  RecordingWriter writer({}, folder);
  for (std::int64_t k = 0;; ++k) {
    writer.write(frame_of(k));
    const char byte = 1;
    if (::write(pipe, &byte, 1) != 1) ::_exit(1);
  }
}

TEST(RecordingWriter, KilledAtAnyMomentLosesAtMostTheFrameAtHand) {
  for (int run = 0; run < 20; ++run) {
    const ScratchFolder folder;
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) write_until_killed(folder.path("new"), ends[1]);
    ::close(ends[1]);
    std::size_t written = 0;
    char byte = 0;
    const std::size_t kill_after = 1 + static_cast<std::size_t>(run);
    while (::read(ends[0], &byte, 1) == 1)
      if (++written == kill_after) ::kill(child, SIGKILL);
    ::close(ends[0]);
    ::waitpid(child, nullptr, 0);
    const auto frames = read_all(folder.path("new"));
    EXPECT_GE(frames.size(), written) << "what was written stays";
    EXPECT_LE(frames.size(), written + 1);
    for (std::size_t k = 0; k < frames.size(); ++k)
      EXPECT_TRUE(same(frames[k].image, frame_of(static_cast<std::int64_t>(k)).image)) << run << ' ' << k;
  }
}

/// While it lives no file can grow beyond `bytes`, as on a disk that is full.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &former_);
    const rlimit small{bytes, former_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &former_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit former_{};
  void (*handler_)(int);
};

TEST(RecordingWriter, ADiskThatIsFullLeavesTheFramesBefore) {
  const ScratchFolder folder;
  RecordingWriter writer({}, folder.path("new"));
  writer.write(frame_of(0));
  writer.write(frame_of(1));
  {
    const FileSizeLimit full(1000);
    EXPECT_THAT(error_of([&] { writer.write(frame_of(2)); }), HasSubstr("cannot be written"));
  }
  EXPECT_EQ(read_all(folder.path("new")).size(), 2U);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path("new/mav0/cam0/data")), {}), 2)
      << "no part of the third image is left";
}

}  // namespace
}  // namespace rastro
