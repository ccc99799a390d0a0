// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/depth_delay_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rastro {
namespace {

/// Waves to the right of where they were, as seen by a camera that swings to and fro.
template <typename Pixel>
Image<Pixel> waves(double aside, double mean, double height) {
  Image<Pixel> image(160, 120);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      image.at(x, y) = static_cast<Pixel>(mean + height * (std::sin((x - aside) / 9.0) + std::sin(y / 7.0)));
  return image;
}

struct Swing {
  double period = 12.0;  ///< Frames.
  int delay = 0;         ///< Of the depth, frames.
  double frame_s = 1.0 / 30.0;
};

std::string told(const Swing& swing) {
  const auto aside = [&](int frame) { return 20.0 * std::sin(2.0 * std::numbers::pi * frame / swing.period); };
  DepthDelayCheck check;
  InputWarnings found;
  for (int k = 0; k < 120; ++k) {
    Frame frame;
    frame.index = k;
    frame.stamp = from_seconds(k * swing.frame_s);
    frame.image = waves<std::uint8_t>(aside(k), 128.0, 50.0);
    frame.depth = waves<float>(aside(k - swing.delay), 2.0, 0.4);
    check.add(frame, found);
  }
  return found.empty() ? "" : found.front().text;
}

TEST(DepthDelayCheck, TellsADelayAndItsSign) {
  EXPECT_EQ(told({}), "");
  EXPECT_NE(told({.delay = 3}).find("0.10 s later than the image"), std::string::npos) << told({.delay = 3});
  EXPECT_NE(told({.delay = -2}).find("0.07 s earlier than the image"), std::string::npos) << told({.delay = -2});
}

/// There, the correlation is high for any delay, and chance says for which it is highest.
TEST(DepthDelayCheck, SmoothMotionSaysNothing) { EXPECT_EQ(told({.period = 40.0, .delay = 2}), ""); }

TEST(DepthDelayCheck, NoClocksAreHalfASecondApart) {
  EXPECT_NE(told({.period = 14.0, .delay = 4}), "");
  EXPECT_EQ(told({.period = 14.0, .delay = 4, .frame_s = 0.15}), "");
}

}  // namespace
}  // namespace rastro
