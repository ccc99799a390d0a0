// SPDX-License-Identifier: Apache-2.0
// OpenNI2 without a camera: its dummy device (320x240), recorded by its recorder and played by its file device.
#include "rastro/dataset/live/openni2.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/dataset_testing.h"

#if RASTRO_WITH_OPENNI2

#include <OpenNI.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>

#include "rastro/base/text_file.h"

namespace rastro {
namespace {

using testing::HasSubstr;

constexpr int width = 320, height = 240;
constexpr int no_dummy = 77;  ///< Exit code where this OpenNI2 has no dummy device.

/// In a process of its own: the dummy device's threads go on while it is closed, and crash then. It must begin before
/// this process has threads of OpenNI2. The exit code.
int apart(const std::function<int()>& work) {
  constexpr unsigned longest_s = 20;  // It hangs now and then.
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(longest_s);
    std::_Exit(work());
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// On a busy machine the dummy device hangs, crashes or gives too few frames now and then.
int in_attempts(const std::function<int()>& work) {
  int code = -1;
  for (int attempt = 0; attempt < 3 && code != 0 && code != no_dummy; ++attempt) code = apart(work);
  return code;
}

/// Records the dummy device, and beside it its depth images as they are given: stamps (us) and depths (mm).
int record_dummy(const std::string& file, int frames) {
  openni::OpenNI::initialize();
  openni::Device device;
  openni::VideoStream depth, color;
  openni::Recorder recorder;
  if (device.open("Dummy") != openni::STATUS_OK || depth.create(device, openni::SENSOR_DEPTH) != openni::STATUS_OK ||
      color.create(device, openni::SENSOR_COLOR) != openni::STATUS_OK ||
      recorder.create(file.c_str()) != openni::STATUS_OK)
    return no_dummy;
  recorder.attach(depth);
  recorder.attach(color);
  recorder.start();
  depth.start();
  color.start();
  std::ofstream given(file + ".depth", std::ios::binary);
  for (int k = 0; k < frames; ++k) {
    openni::VideoFrameRef frame;
    if (depth.readFrame(&frame) != openni::STATUS_OK) return 1;
    const std::uint64_t stamp = frame.getTimestamp();
    given.write(reinterpret_cast<const char*>(&stamp), sizeof stamp);
    given.write(static_cast<const char*>(frame.getData()), std::streamsize{2} * width * height);
  }
  given.close();
  color.stop();
  depth.stop();
  recorder.stop();
  recorder.destroy();
  return 0;
}

/// A depth image as the device gave it.
struct Given {
  std::uint64_t stamp_us = 0;
  std::vector<std::uint16_t> depth;
};

std::vector<Given> read_given(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<Given> given;
  Given next;
  next.depth.resize(width * height);
  while (stream.read(reinterpret_cast<char*>(&next.stamp_us), sizeof next.stamp_us) &&
         stream.read(reinterpret_cast<char*>(next.depth.data()), std::streamsize{2} * width * height))
    given.push_back(next);
  return given;
}

void put_number(std::string& text, std::uint32_t value) {
  for (int k = 0; k < 4; ++k) text += static_cast<char>(value >> (8 * k));
}

/// The file device gives no frame of a stream whose record does not tell how it was cropped, and the dummy device does
/// not tell. So a property that nobody reads, with twelve bytes of value too, becomes that of the cropping: off.
void tell_cropping(const std::string& file) {
  constexpr std::string_view unread{"xnSupportedMapOutputModes", 26}, cropping{"xnCropping", 11};
  constexpr std::size_t value_bytes = 12;
  std::string before, after;
  put_number(before, unread.size());
  before += unread;
  put_number(after, cropping.size());
  after += cropping;
  put_number(after, value_bytes);
  after.resize(before.size() + 4 + value_bytes);
  std::string bytes = read_text_file(file);
  for (auto at = bytes.find(before); at != std::string::npos; at = bytes.find(before, at))
    bytes.replace(at, after.size(), after);
  std::ofstream(file, std::ios::binary) << bytes;
}

std::vector<Frame> read_all(LiveSource& source, std::size_t most) {
  std::vector<Frame> frames;
  for (int k = 0; k < 100 && frames.size() < most && source.condition().state != LiveState::ended; ++k)
    if (auto arrived = source.next(ns_per_second / 10)) frames.push_back(std::move(arrived->frame));
  return frames;
}

/// Whether the dummy device, opened by its name, gives frames.
int see_dummy() {
  SteadyClock clock;
  std::unique_ptr<LiveSource> source;
  try {
    source = open_openni2("openni2:Dummy", "Dummy", {}, clock);
  } catch (const Error&) {
    return no_dummy;
  }
  const std::vector<Frame> frames = read_all(*source, 3);
  const auto& warnings = source->info().warnings;
  const bool warns = std::any_of(warnings.begin(), warnings.end(), [](const std::string& line) {
    return line.find("does not register its depth to color") != line.npos;
  });
  // It is not closed.
  static_cast<void>(source.release());
  const bool is_good = frames.size() == 3 && frames[0].depth.width() == width && frames[1].stamp > frames[0].stamp;
  return is_good && warns ? 0 : 1;
}

bool is_same(const Frame& frame, const Given& given) {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto depth = static_cast<float>(given.depth[static_cast<std::size_t>(y * width + x)]) * 0.001F;
      if (std::abs(frame.depth.at(x, y) - depth) > 1e-6F) return false;
    }
  return true;
}

struct Matches {
  int same = 0, other = 0;  ///< Frames with the depth that was given at their stamp, and with another one.
};

/// `later`: by how much the stamps as they were given are behind those of the recording, which begin at 0.
Matches match(const std::vector<Frame>& frames, const std::vector<Given>& given, std::int64_t later_us) {
  Matches matches;
  for (const Frame& frame : frames)
    for (const Given& each : given)
      if (frame.depth_stamp / 1000 + later_us == static_cast<std::int64_t>(each.stamp_us))
        (is_same(frame, each) ? matches.same : matches.other)++;
  return matches;
}

class OpenNi2 : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    seen_ = in_attempts(see_dummy);
    recorded_ = in_attempts([] { return record_dummy(file(), 12); });
    if (recorded_ == 0) tell_cropping(file());
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string file() { return folder_->path("dummy.oni"); }

  static inline std::unique_ptr<ScratchFolder> folder_;
  static inline int seen_ = 0, recorded_ = 0;
  SteadyClock clock_;
};

TEST_F(OpenNi2, ACameraIsOpenedByItsUri) {
  if (seen_ == no_dummy) GTEST_SKIP() << "this OpenNI2 has no dummy device";
  EXPECT_EQ(seen_, 0);
}

TEST_F(OpenNi2, ARecordingIsPlayedAsItWasRecordedAndItsEndIsTold) {
  if (recorded_ == no_dummy) GTEST_SKIP() << "this OpenNI2 has no dummy device";
  ASSERT_EQ(recorded_, 0);
  const std::vector<Given> given = read_given(file() + ".depth");
  OpenOptions options;
  options.want_color = true;
  // OpenNI2 keeps the newest image alone: on a busy machine some are missed.
  std::vector<Frame> frames;
  for (int attempt = 0; attempt < 3 && frames.size() < 3; ++attempt) {
    const auto source = open_openni2("openni2:" + file(), file(), options, clock_);
    EXPECT_TRUE(source->info().has_depth);
    frames = read_all(*source, 1000);
    EXPECT_EQ(source->condition().state, LiveState::ended);
  }
  ASSERT_GE(frames.size(), 3U);
  for (const Frame& frame : frames) {
    ASSERT_EQ(frame.depth.width(), width);
    EXPECT_EQ(frame.color.width(), width);
    EXPECT_LE(std::abs(frame.stamp - frame.depth_stamp), 20'000'000);
  }
  // Which one was given first is not told, nor whether it was seen when it was recorded.
  Matches best;
  for (const Frame& frame : frames)
    for (const Given& each : given) {
      const auto matches = match(frames, given, static_cast<std::int64_t>(each.stamp_us) - frame.depth_stamp / 1000);
      if (matches.same > best.same) best = matches;
    }
  EXPECT_GE(best.same, 3);
  EXPECT_EQ(best.other, 0);
}

TEST_F(OpenNi2, WhatIsNoRecordingSaysSo) {
  folder_->write("no.oni", "text");
  EXPECT_THAT(error_of([&] { open_openni2("openni2:no.oni", folder_->path("no.oni"), {}, clock_); }),
              HasSubstr("is it a recording of OpenNI2"));
}

}  // namespace
}  // namespace rastro

#else

namespace rastro {
namespace {

TEST(OpenNi2, ABuildWithoutItSaysHowToGetIt) {
  SteadyClock clock;
  EXPECT_THAT(error_of([&] { open_openni2("openni2:", "", {}, clock); }), testing::HasSubstr("RASTRO_WITH_OPENNI2"));
}

}  // namespace
}  // namespace rastro

#endif
