// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/matched_features.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Spots of any size and intensity.
GrayImage spots() {
  GrayImage image(320, 240);
  for (int y = 0; y < image.height(); ++y) std::fill_n(image.row(y), image.width(), std::uint8_t{128});
  Random random(4);
  for (int k = 0; k < 150; ++k) {
    const double cx = random.uniform(10.0, 310.0), cy = random.uniform(10.0, 230.0), radius = random.uniform(3.0, 9.0);
    const double gray = random.uniform(0.0, 255.0);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        if (std::hypot(x - cx, y - cy) < radius) image.at(x, y) = static_cast<std::uint8_t>(gray);
  }
  return image;
}

TEST(MatchedFeatures, AMatchedFeatureKeepsItsId) {
  const Camera camera{.width = 320, .height = 240, .fx = 260, .fy = 260, .cx = 159.5, .cy = 119.5};
  const GrayImage image = spots(), blank(320, 240);
  for (const char* descriptor : {"sift", "orb"}) {
    SCOPED_TRACE(descriptor);
    MatchedFeatures features({.descriptor = descriptor, .extraction = {}, .matching = {}}, camera, nullptr);
    const RayObservations first = features.next(image.view()), again = features.next(image.view());
    ASSERT_GT(first.size(), 100U);
    const SharedRays shared = shared_rays(first, again);
    EXPECT_GT(shared.ids.size(), first.size() * 3 / 4);
    EXPECT_EQ(median_motion_px(shared, camera.fx), 0.0);
    EXPECT_TRUE(features.next(blank.view()).empty());
    EXPECT_TRUE(shared_rays(again, features.next(image.view())).ids.empty())
        << "matched across a frame without features";
  }
}

TEST(MatchedFeatures, RefusesAnUnknownDescriptor) {
  EXPECT_THROW(MatchedFeatures({.descriptor = "brisk", .extraction = {}, .matching = {}}, Camera{}, nullptr), Error);
}

TEST(RayObservations, SharedRaysAreThoseOfTheSameId) {
  const RayObservations first = {{1, {0.0, 0.0}}, {4, {0.1, 0.0}}, {9, {0.2, 0.0}}};
  const RayObservations second = {{4, {0.1, 0.1}}, {7, {0.5, 0.5}}, {9, {0.2, 0.3}}};
  const SharedRays shared = shared_rays(first, second);
  EXPECT_EQ(shared.ids, (std::vector<std::int64_t>{4, 9}));
  EXPECT_EQ(shared.a[1], Eigen::Vector2d(0.2, 0.0));
  EXPECT_EQ(shared.b[1], Eigen::Vector2d(0.2, 0.3));
  EXPECT_EQ(find_ray(first, 7), nullptr);
  EXPECT_NEAR(median_motion_px(shared, 100.0), 30.0, 1e-9);  // the upper one of two
  EXPECT_EQ(median_motion_px({}, 100.0), 0.0);
}

}  // namespace
}  // namespace rastro
