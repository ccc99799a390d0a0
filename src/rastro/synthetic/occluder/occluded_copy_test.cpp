// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/occluder/occluded_copy.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/synthetic/occluder/occluder_masks.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

constexpr int frame_count = 24;

/// A recording of a constant image.
class StillSource : public Source {
 public:
  StillSource() {
    info_.path = "still";
    info_.format = "images";
    CalibratedCamera camera;
    camera.name = "cam0";
    camera.camera = Camera{64, 48, 60.0, 61.0, 32.0, 24.0, Distortion::radial_tangential, {-0.1, 0.01, 0, 0, 0}};
    info_.cameras.push_back(camera);
    info_.ground_truth = {{5, SE3()}, {1005, SE3(SO3(), {1, 2, 3})}};
    info_.ground_truth_frame = "camera";
  }
  const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (next_ == frame_count) return std::nullopt;
    const std::int64_t k = next_++;
    if (k == broken_frame) throw Error("the image is truncated", "4.png", "copy it again");
    Frame frame;
    frame.index = k;
    frame.stamp = repeated_stamps ? 7 : 1000 * k;
    frame.image = GrayImage(k == odd_frame ? 65 : 64, 48);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < frame.image.width(); ++x) frame.image.at(x, y) = static_cast<std::uint8_t>(4 * x + y);
    return frame;
  }
  std::int64_t broken_frame = -1, odd_frame = -1;
  bool repeated_stamps = false;

 private:
  SourceInfo info_;
  std::int64_t next_ = 0;
};

class OccludedCopy : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = scratch_path(test->name());
  }
  void TearDown() override { fs::remove_all(folder_); }
  OccludedCopyResult copy(const fs::path& name, int threads, StillSource source = {}, bool overwrite = false) {
    TaskPool pool(threads);
    return write_occluded_copy(source, folder_ / name, {3, overwrite}, pool);
  }
  fs::path folder_;
};

TEST_F(OccludedCopy, SameBytesForAnyNumberOfThreads) {
  copy("one", 1);
  copy("two", 2);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "one")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    EXPECT_EQ(bytes_of(entry.path()), bytes_of(folder_ / "two" / fs::relative(entry.path(), folder_ / "one")));
  }
  EXPECT_EQ(files, 2 * frame_count + 4);
}

TEST_F(OccludedCopy, MasksAreReadBackAndGiveTheCoveredPixels) {
  const OccludedCopyResult result = copy("", 1);
  EXPECT_EQ(result.frames, frame_count);
  EXPECT_GT(result.covered_frames, 5);
  ASSERT_TRUE(OccluderMasks::present(folder_));
  EXPECT_FALSE(OccluderMasks::present(folder_ / "elsewhere"));
  const OccluderMasks masks(folder_);
  double covered = 0;
  for (std::int64_t k = 0; k < frame_count; ++k) {
    const cv::Mat mask =
        cv::imread((folder_ / "mav0/occluder" / (std::to_string(1000 * k) + ".png")).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_EQ(mask.cols, 64);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        ASSERT_EQ(masks.covered(1000 * k, {x + 0.3, y - 0.3}, 0.0), mask.at<std::uint8_t>(y, x) == 255);
        covered += mask.at<std::uint8_t>(y, x) == 255;
      }
    }
  }
  EXPECT_NEAR(covered / (64 * 48 * frame_count), result.covered_share, 1e-9);
  EXPECT_FALSE(masks.covered(0, {1e9, -1e9}, 3.0));
  EXPECT_THROW(masks.covered(77, {1, 1}, 0.0), Error);
}

TEST_F(OccludedCopy, RadiusIsExact) {
  copy("", 1);
  const OccluderMasks masks(folder_);
  for (std::int64_t k = 0; k < frame_count; ++k) {
    const GrayImage mask = masks.mask(1000 * k);
    for (int x = 0; x < 64; x += 5) {
      bool expected = false;
      for (int v = 0; v < 48; ++v)
        for (int u = 0; u < 64; ++u)
          expected = expected || (mask.at(u, v) != 0 && (u - x) * (u - x) + (v - 20) * (v - 20) <= 25);
      EXPECT_EQ(masks.covered(1000 * k, {x, 20}, 5.0), expected);
    }
  }
}

TEST_F(OccludedCopy, KeepsTimesCalibrationAndGroundTruth) {
  copy("", 1);
  EXPECT_THAT(bytes_of(folder_ / "mav0/cam0/data.csv"), HasSubstr("\n23000,23000.png\n"));
  EXPECT_THAT(bytes_of(folder_ / "mav0/cam0/sensor.yaml"), HasSubstr("intrinsics: [60, 61, 32, 24]"));
  EXPECT_THAT(bytes_of(folder_ / "mav0/cam0/sensor.yaml"), HasSubstr("distortion_coefficients: [-0.1, 0.01, 0, 0]"));
  EXPECT_THAT(bytes_of(folder_ / "mav0/state_groundtruth_estimate0/data.csv"), HasSubstr("\n1005,1,2,3,1,0,0,0\n"));
}

TEST_F(OccludedCopy, BadInputIsOneError) {
  StillSource odd;
  odd.odd_frame = 3;
  EXPECT_THROW(copy("odd", 1, odd), Error);
  StillSource repeated;
  repeated.repeated_stamps = true;
  EXPECT_THROW(copy("repeated", 1, repeated), Error);
  copy("full", 1);
  EXPECT_THROW(copy("full", 1), Error) << "does not overwrite existing files";
  EXPECT_EQ(copy("full", 1, {}, true).frames, frame_count);
  StillSource broken;
  broken.broken_frame = 4;
  const OccludedCopyResult result = copy("broken", 1, broken);
  EXPECT_EQ(result.frames, frame_count - 1);
  EXPECT_EQ(result.skipped, 1);
}

}  // namespace
}  // namespace rastro
