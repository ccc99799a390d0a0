// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/method.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

TEST(EkfMethod, NeedsOdometryAndScansOrLandmarks) {
  const auto method = ekf_slam_method();
  for (const bool odometry : {false, true}) {
    for (const bool scan : {false, true}) {
      for (const bool landmarks : {false, true}) {
        SourceInfo source;
        source.path = "there";
        source.has_odometry = odometry;
        source.has_scan = scan;
        source.has_landmarks = landmarks;
        if (odometry && (scan || landmarks)) {
          EXPECT_NE(method->make(source, {}), nullptr);
        } else {
          EXPECT_THROW(method->make(source, {}), Error);
        }
      }
    }
  }
}

TEST(EkfMethod, MakesAFilterWithItsOptions) {
  const auto method = ekf_slam_method();
  OptionTable table = method->options();
  table.set("max_landmarks", "1", "test");
  table.set("observations", "1", "test");
  SourceInfo source;
  source.has_odometry = source.has_landmarks = true;
  const auto slam = method->make(source, {});
  Frame frame;
  frame.odometry_from_body = SE2();
  frame.landmarks = {{1, 3.0, 0.0}, {2, 3.0, 1.0}};
  slam->process(frame);
  EXPECT_EQ(slam->snapshot()->layer<LandmarkLayer>()->landmarks.size(), 1U);
}

}  // namespace
}  // namespace rastro
