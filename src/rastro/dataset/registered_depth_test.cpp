// SPDX-License-Identifier: Apache-2.0
// Depth of another camera, put into the color image as a recording is read.
#include "rastro/dataset/registered_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/check.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/describe.h"

namespace rastro {
namespace {

using testing::HasSubstr;

/// A wall at 2 m seen by a color camera of 8x6 pixels and a depth camera of 16x12 that stands half a meter behind it.
class RegisteredDepth : public testing::Test {
 protected:
  RegisteredDepth() {
    folder_.write("rgb.txt", "1.0 rgb/0.png\n1.1 rgb/1.png\n");
    folder_.write("depth.txt", "1.0 depth/0.png\n1.1 depth/1.png\n");
    for (const char* name : {"0.png", "1.png"}) {
      folder_.write_color(std::string("rgb/") + name, 50);
      folder_.write_depth(std::string("depth/") + name, 2000, 16, 12);
    }
  }

  static std::string calibration(int depth_width = 16) {
    return "image_width: 8\nimage_height: 6\ncamera_matrix: [8, 0, 3.5, 0, 8, 2.5, 0, 0, 1]\ndepth_factor: 1000\n"
           "depth_camera:\n  image_width: " +
           std::to_string(depth_width) +
           "\n  image_height: 12\n  camera_matrix: [12, 0, 7.5, 0, 12, 5.5, 0, 0, 1]\n"
           "color_from_depth: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -0.5, 0, 0, 0, 1]\n";
  }

  Frame first(const OpenOptions& options) const { return *open(folder_.path(), options)->next(); }

  static OpenOptions depth_wanted() {
    OpenOptions options;
    options.want_depth = true;
    return options;
  }

  ScratchFolder folder_;
};

TEST_F(RegisteredDepth, ByTheCalibrationInTheFolderOrTheOneGiven) {
  OpenOptions options = depth_wanted();
  EXPECT_THAT(error_of([&] { first(options); }), HasSubstr("16x12")) << "nothing says where the depth camera is";
  folder_.write("other.yaml", calibration());
  options.calibration_file = folder_.path("other.yaml");
  EXPECT_EQ(first(options).depth.width(), 8);
  folder_.write("camera.yaml", calibration());
  for (const int read_ahead : {0, 4}) {
    options = depth_wanted();
    options.read_ahead = read_ahead;
    const auto source = open(folder_.path(), options);
    EXPECT_THAT(describe(source->info(), false), HasSubstr("put into the color image"));
    for (int k = 0; k < 2; ++k) {
      const Frame frame = *source->next();
      ASSERT_EQ(frame.depth.width(), 8);
      for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x) EXPECT_NEAR(frame.depth.at(x, y), 1.5F, 1e-5F) << x << ' ' << y;
    }
  }
}

TEST_F(RegisteredDepth, RawDepthIsThatOfTheDepthCamera) {
  folder_.write("camera.yaml", calibration());
  OpenOptions options = depth_wanted();
  options.raw_depth = true;
  EXPECT_EQ(first(options).depth.width(), 16);
  EXPECT_EQ(first(options).depth.at(3, 4), 2.0F);
}

TEST_F(RegisteredDepth, DepthOfAnotherSizeThanItsCameraEndsTheRecording) {
  folder_.write("camera.yaml", calibration(20));
  EXPECT_THROW(first(depth_wanted()), UnusableSource);
  EXPECT_EQ(check(folder_.path(), {}, {}).size_changes.size(), 2U);
  folder_.write("camera.yaml", calibration());
  EXPECT_TRUE(check(folder_.path(), {}, {}).size_changes.empty());
}

}  // namespace
}  // namespace rastro
