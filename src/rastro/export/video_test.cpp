// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/video.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/track_frames_testing.h"

namespace rastro {
namespace {

std::unique_ptr<TrackVideo> make_video(const std::filesystem::path& path) {
  try {
    return std::make_unique<TrackVideo>(path);
  } catch (const Error& error) {
    if (std::string(error.what()).find("built without video") != std::string::npos) return nullptr;
    throw;
  }
}

std::uintmax_t size_of_video(int frames, const std::string& name) {
  const auto path = scratch_folder("video") / name;
  const auto video = make_video(path);
  if (!video) return 0;
  const GrayImage image(640, 101);
  for (int i = 0; i < frames; ++i) {
    video->write(make_frame(i, {make_feature(i, TrackState::fresh, 30.0F + static_cast<float>(i), 50.0F)}), image);
  }
  video->finish();
  return std::filesystem::file_size(path);
}

TEST(TrackVideo, HoldsEveryFrameFromTheFirstOn) {
  const auto one = size_of_video(1, "one.avi");
  if (one == 0) GTEST_SKIP() << "built without video files";
  const auto three = size_of_video(3, "three.avi");
  const auto five = size_of_video(5, "five.avi");
  EXPECT_GT(one, 2000U);
  EXPECT_GT(three, one);
  EXPECT_GT(five, three);
}

TEST(TrackVideo, RefusesAFolderThatIsNotThere) { EXPECT_THROW(TrackVideo("/nowhere/at/all.avi"), Error); }

}  // namespace
}  // namespace rastro
