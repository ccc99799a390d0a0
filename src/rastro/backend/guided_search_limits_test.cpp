// SPDX-License-Identifier: Apache-2.0
// Where a guided search looks, and which landmarks it looks for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "rastro/backend/descriptor_testing.h"
#include "rastro/backend/guided_search.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

using testing::flipped;
using testing::random_descriptor;

constexpr float not_known = std::numeric_limits<float>::quiet_NaN();
constexpr int level_count = 8;

Camera wide_camera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500.0;
  camera.fy = 400.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  return camera;
}

Descriptor one_descriptor() {
  Random random(5);
  return random_descriptor(random);
}

/// Features at these pixels and levels, all alike.
FeatureGrid grid_of(const Camera& camera, const std::vector<Eigen::Vector2f>& pixels,
                    const std::vector<std::uint8_t>& feature_levels, const std::vector<float>& rights = {}) {
  Features features;
  features.keypoints.resize(pixels.size());
  features.levels = feature_levels;
  features.descriptors.assign(pixels.size(), one_descriptor());
  return {camera, std::make_shared<const Features>(std::move(features)), pixels,
          rights.empty() ? std::vector<float>(pixels.size(), not_known) : rights};
}

/// Whether the only feature, at this pixel and level, is found for a point.
bool finds_point(const Eigen::Vector2f& pixel, int feature_level, const Eigen::Vector3d& point, int level) {
  const Camera camera = wide_camera();
  const FeatureGrid grid = grid_of(camera, {pixel}, {static_cast<std::uint8_t>(feature_level)});
  std::vector<float> radii;
  for (int k = 0; k < level_count; ++k) radii.push_back(static_cast<float>(3 + k));
  GuidedSearch search(camera, grid, radii, {});
  const Descriptor descriptor = one_descriptor();
  return search.add_point(0, point, level, descriptor) && !search.match({}).empty();
}

TEST(GuidedSearchLimits, APointIsExpectedAtItsLevelPlusOrMinusOne) {
  const Eigen::Vector2f center(320.0F, 240.0F);
  for (int level = -2; level < level_count + 2; ++level) {
    const int expected = std::clamp(level, 0, level_count - 1);
    for (int feature = 0; feature < level_count; ++feature)
      EXPECT_EQ(finds_point(center, feature, {0.0, 0.0, 2.0}, level), std::abs(feature - expected) <= 1)
          << level << ' ' << feature;
  }
}

TEST(GuidedSearchLimits, TheWindowIsThatOfThePointsLevelAroundItsProjection) {
  const Eigen::Vector3d point(0.4, -0.6, 2.0);
  const Eigen::Vector2f projected(420.0F, 120.0F);
  for (int level = 0; level < level_count; ++level) {
    for (const float sign : {-1.0F, 1.0F}) {
      const float inside = sign * (static_cast<float>(3 + level) - 0.01F), outside = inside + 0.02F * sign;
      EXPECT_TRUE(finds_point(projected + Eigen::Vector2f(inside, 0.0F), level, point, level)) << level;
      EXPECT_TRUE(finds_point(projected + Eigen::Vector2f(0.0F, inside), level, point, level)) << level;
      EXPECT_FALSE(finds_point(projected + Eigen::Vector2f(outside, 0.0F), level, point, level)) << level;
      EXPECT_FALSE(finds_point(projected + Eigen::Vector2f(0.0F, outside), level, point, level)) << level;
    }
  }
}

TEST(GuidedSearchLimits, TheRightPixelMustBeWithinTheWindowWhereItIsKnown) {
  const Camera camera = wide_camera();
  const Eigen::Vector3d point(0.4, -0.6, 2.0);
  const float expected = 420.0F - 500.0F * 0.2F / 2.0F;
  const Descriptor descriptor = one_descriptor();
  for (const auto& [right, found] : {std::pair{expected - 4.99F, true},
                                     {expected - 5.01F, false},
                                     {expected + 4.99F, true},
                                     {expected + 5.01F, false},
                                     {not_known, true}}) {
    const FeatureGrid grid = grid_of(camera, {{420.0F, 120.0F}}, {3}, {right});
    GuidedSearch search(camera, grid, std::vector<float>(level_count, 5.0F), {.baseline = 0.2});
    ASSERT_TRUE(search.add_point(0, point, 3, descriptor));
    EXPECT_EQ(search.match({}).size(), found ? 1U : 0U) << right;
  }
}

/// A landmark seen from `distance` at an angle to its mean direction; shown from 1 m to 4 m.
bool is_searched(double distance, double angle) {
  const Camera camera = wide_camera();
  const FeatureGrid grid = grid_of(camera, {{320.0F, 240.0F}}, {0});
  GuidedSearch search(camera, grid, std::vector<float>(level_count, 5.0F), {.min_view_cosine = 0.5});
  const Eigen::Vector3d position(1.0, 2.0, 3.0), direction = Eigen::Vector3d::UnitX();
  const Descriptor descriptor = one_descriptor();
  const Eigen::Vector3d center = position - distance * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  return search.add_landmark(0, {position, direction, 1.0F, 4.0F, descriptor}, {0.0, 0.0, distance}, center);
}

TEST(GuidedSearchLimits, ALandmarkIsSearchedForAQuarterBeyondItsDistancesAndUpToTheAngle) {
  EXPECT_TRUE(is_searched(0.81, 0.0));
  EXPECT_FALSE(is_searched(0.79, 0.0));
  EXPECT_TRUE(is_searched(4.99, 0.0));
  EXPECT_FALSE(is_searched(5.01, 0.0));
  for (const double distance : {1.0, 3.0}) {
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_TRUE(is_searched(distance, sign * (M_PI / 3.0 - 0.01)));
      EXPECT_FALSE(is_searched(distance, sign * (M_PI / 3.0 + 0.01)));
    }
  }
}

/// The level whose scale is nearest to the ratio of distances, in logarithms.
TEST(GuidedSearchLimits, ALandmarksLevelFollowsFromItsDistance) {
  const Camera camera = wide_camera();
  const Eigen::Vector3d position(1.0, 2.0, 3.0), direction = Eigen::Vector3d::UnitZ();
  const Descriptor descriptor = one_descriptor();
  for (double exponent = 0.05; exponent < 6.9; exponent += 0.1) {
    const double distance = 6.0 / std::pow(1.3, exponent);
    const int expected = static_cast<int>(std::lround(exponent));
    std::set<int> found;
    for (int level = 0; level < level_count; ++level) {
      const FeatureGrid grid = grid_of(camera, {{320.0F, 240.0F}}, {static_cast<std::uint8_t>(level)});
      GuidedSearch search(camera, grid, std::vector<float>(level_count, 5.0F), {.scale_factor = 1.3});
      ASSERT_TRUE(search.add_landmark(0, {position, direction, 0.5F, 6.0F, descriptor}, {0.0, 0.0, distance},
                                      position - distance * direction));
      if (!search.match({}).empty()) found.insert(level);
    }
    std::set<int> nearby;
    for (int level = std::max(0, expected - 1); level <= std::min(level_count - 1, expected + 1); ++level)
      nearby.insert(level);
    EXPECT_EQ(found, nearby) << exponent;
  }
}

TEST(GuidedSearchLimits, ALandmarkAnywhereMayBeOfAnyLevel) {
  const Camera camera = wide_camera();
  const Descriptor descriptor = one_descriptor();
  for (int level = 0; level < level_count; ++level) {
    const FeatureGrid grid = grid_of(camera, {{639.0F, 1.0F}}, {static_cast<std::uint8_t>(level)}, {100.0F});
    GuidedSearch search(camera, grid, std::vector<float>(level_count, 5.0F), {.baseline = 0.1});
    search.add_anywhere(0, descriptor);
    EXPECT_EQ(search.match({}).size(), 1U) << level;
  }
}

TEST(FeatureGridBounds, AreTheImageAndAPixelMoreWithoutDistortion) {
  const FeatureGrid grid = grid_of(wide_camera(), {{100.0F, 50.0F}}, {0});
  for (const auto& [x, y, inside] : {std::tuple{0.0F, 0.0F, true},
                                     {-0.01F, 5.0F, false},
                                     {5.0F, -0.01F, false},
                                     {640.99F, 480.99F, true},
                                     {641.0F, 5.0F, false},
                                     {5.0F, 481.0F, false}})
    EXPECT_EQ(grid.holds(x, y), inside) << x << ' ' << y;
}

TEST(FeatureGridBounds, AreThoseOfTheFeaturesWithDistortionOrWithoutSize) {
  Camera distorted = wide_camera(), sizeless = wide_camera();
  distorted.distortion = Distortion::radial_tangential;
  sizeless.width = 0;
  for (const Camera& camera : {distorted, sizeless}) {
    const FeatureGrid grid = grid_of(camera, {{-20.0F, 50.0F}, {not_known, not_known}, {700.0F, 90.0F}}, {0, 0, 0});
    for (const auto& [x, y, inside] : {std::tuple{-20.0F, 50.0F, true},
                                       {-20.1F, 60.0F, false},
                                       {5.0F, 49.9F, false},
                                       {700.9F, 90.9F, true},
                                       {701.0F, 60.0F, false},
                                       {5.0F, 91.0F, false}})
      EXPECT_EQ(grid.holds(x, y), inside) << x << ' ' << y;
  }
}

TEST(FeatureGridBounds, FeaturesAreFoundByCellsRowByRow) {
  // Cells of 16 pixels: the order of what is found is theirs.
  const FeatureGrid grid =
      grid_of(wide_camera(), {{33.0F, 17.0F}, {15.9F, 1.0F}, {16.1F, 2.0F}, {1.0F, 15.9F}, {1.0F, 16.1F}, {2.0F, 3.0F}},
              {0, 0, 0, 0, 0, 0});
  std::vector<std::uint32_t> found;
  grid.find(20.0F, 20.0F, 20.0F, 0, 0, found);
  EXPECT_THAT(found, ::testing::ElementsAre(1U, 3U, 5U, 2U, 4U, 0U));
}

TEST(MatchWithinRadius, LevelsMayDifferByOneAndPositionsMustBeKnown) {
  for (int first = 0; first < level_count; ++first) {
    for (int second = 0; second < level_count; ++second) {
      const FeatureGrid a = grid_of(wide_camera(), {{50.0F, 60.0F}}, {static_cast<std::uint8_t>(first)});
      const FeatureGrid b = grid_of(wide_camera(), {{55.0F, 60.0F}}, {static_cast<std::uint8_t>(second)});
      EXPECT_EQ(match_within_radius(a, b, 10.0F, {}).size(), std::abs(first - second) <= 1 ? 1U : 0U);
    }
  }
  const FeatureGrid unknown = grid_of(wide_camera(), {{not_known, not_known}, {52.0F, 60.0F}}, {0, 0}, {30.0F, 30.0F});
  const FeatureGrid known = grid_of(wide_camera(), {{55.0F, 60.0F}}, {0}, {900.0F});
  EXPECT_THAT(match_within_radius(unknown, known, 10.0F, {}), ::testing::ElementsAre(::testing::Pair(1U, 0U)))
      << "whatever the right camera shows";
  EXPECT_TRUE(match_within_radius(known, unknown, 2.99F, {}).empty());
}

TEST(MatchInWindows, AFeatureGoesToTheMostSimilarSubjectThenToTheFirst) {
  const Descriptor descriptor = one_descriptor(), near = flipped(descriptor, 4), far = flipped(descriptor, 9);
  const FeatureGrid grid = grid_of(wide_camera(), {{50.0F, 60.0F}}, {0});
  const auto subject_of = [&](const Descriptor& first, const Descriptor& second) {
    const std::vector<SearchWindow> windows = {{7, 50.0F, 60.0F, 5.0F, not_known, 0, 7, &first},
                                               {3, 50.0F, 60.0F, 5.0F, not_known, 0, 7, &second}};
    const auto matches = match_in_windows(grid, windows, {});
    EXPECT_EQ(matches.size(), 1U);
    return matches.front().subject;
  };
  EXPECT_EQ(subject_of(near, far), 7U);
  EXPECT_EQ(subject_of(far, near), 3U);
  EXPECT_EQ(subject_of(near, near), 7U);
}

}  // namespace
}  // namespace rastro
