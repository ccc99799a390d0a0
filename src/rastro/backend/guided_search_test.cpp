// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/guided_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/backend/descriptor_testing.h"
#include "rastro/base/random.h"
#include "rastro/feature/hamming.h"

namespace rastro {
namespace {

using ::testing::ElementsAre;
using testing::flipped;
using ::testing::IsEmpty;
using ::testing::Pair;
using testing::random_descriptor;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Camera vga() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500.0;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

/// Features of an image under construction.
struct Drawing {
  void add(float x, float y, int level, const Descriptor& descriptor, float right = nan) {
    features.keypoints.push_back({x, y, 31, 0, 1});
    features.levels.push_back(static_cast<std::uint8_t>(level));
    features.descriptors.push_back(descriptor);
    pixels.emplace_back(x, y);
    rights.push_back(right);
  }
  FeatureGrid grid() const { return {vga(), std::make_shared<const Features>(features), pixels, rights}; }

  Features features;
  std::vector<Eigen::Vector2f> pixels;
  std::vector<float> rights;
};

Drawing random_drawing(Random& random, int count) {
  Drawing drawing;
  for (int i = 0; i < count; ++i) {
    const auto x = static_cast<float>(random.uniform(0.0, 640.0)), y = static_cast<float>(random.uniform(0.0, 480.0));
    drawing.add(x, y, static_cast<int>(random.below(8)), random_descriptor(random));
  }
  return drawing;
}

SearchWindow random_window(Random& random, const Descriptor& descriptor) {
  const int level = static_cast<int>(random.below(8));
  return {0,
          static_cast<float>(random.uniform(-30.0, 670.0)),
          static_cast<float>(random.uniform(-30.0, 510.0)),
          static_cast<float>(random.uniform(1.0, 150.0)),
          nan,
          static_cast<std::uint8_t>(std::max(0, level - 1)),
          static_cast<std::uint8_t>(level + 1),
          &descriptor};
}

bool is_inside(const FeatureGrid& grid, std::size_t i, const SearchWindow& window) {
  const Eigen::Vector2f offset = grid.pixel(i) - Eigen::Vector2f(window.x, window.y);
  return grid.level(i) >= window.min_level && grid.level(i) <= window.max_level &&
         std::abs(offset.x()) <= window.radius && std::abs(offset.y()) <= window.radius;
}

TEST(FeatureGrid, EqualsBruteForce) {
  Random random(1);
  const FeatureGrid grid = random_drawing(random, 800).grid();
  const Descriptor any = random_descriptor(random);
  std::size_t total = 0;
  for (int k = 0; k < 300; ++k) {
    const SearchWindow window = random_window(random, any);
    std::vector<std::uint32_t> found, expected;
    grid.find(window.x, window.y, window.radius, window.min_level, window.max_level, found);
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
      if (is_inside(grid, i, window)) expected.push_back(i);
    }
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    total += found.size();
  }
  EXPECT_GT(total, 1000U);
}

TEST(FeatureGrid, NeverFindsFeaturesWithoutPixelAndKnowsTheImageBounds) {
  Random random(2);
  Drawing drawing;
  drawing.add(nan, nan, 0, random_descriptor(random));
  drawing.add(100.0F, 100.0F, 0, random_descriptor(random));
  drawing.add(0.0F, 0.0F, 0, random_descriptor(random));
  const FeatureGrid grid = drawing.grid();
  std::vector<std::uint32_t> found;
  grid.find(320.0F, 240.0F, 1000.0F, 0, 7, found);
  EXPECT_THAT(found, ::testing::UnorderedElementsAre(1U, 2U));
  for (const auto& [x, y] : {std::pair{0.0F, -5.0F}, {-5.0F, 0.0F}}) {
    grid.find(x, y, 5.0F, 0, 7, found);
    EXPECT_THAT(found, ElementsAre(2U)) << "a window that only touches it holds it";
  }
  EXPECT_TRUE(grid.holds(0.0F, 479.0F));
  EXPECT_FALSE(grid.holds(-1.0F, 10.0F));
  EXPECT_FALSE(grid.holds(10.0F, 482.0F));
  EXPECT_FALSE(grid.holds(nan, 10.0F));
}

TEST(FeatureGrid, OfAnImageWithoutFeaturesFindsNone) {
  const FeatureGrid grid = Drawing().grid();
  std::vector<std::uint32_t> found{7};
  grid.find(100.0F, 100.0F, 50.0F, 0, 7, found);
  EXPECT_THAT(found, IsEmpty());
}

/// The definition of match_in_windows(), one window and one feature after the other.
std::vector<FeatureMatch> compare_all(const FeatureGrid& grid, const std::vector<SearchWindow>& windows,
                                      const MatchLimits& limits) {
  std::vector<FeatureMatch> matches;
  for (std::uint32_t i = 0; i < grid.size(); ++i) {
    FeatureMatch best{0, i, 257};
    for (const SearchWindow& window : windows) {
      std::vector<std::pair<int, std::uint32_t>> distances;
      for (std::uint32_t k = 0; k < grid.size(); ++k) {
        if (is_inside(grid, k, window))
          distances.emplace_back(hamming_distance(*window.descriptor, grid.descriptor(k)), k);
      }
      std::sort(distances.begin(), distances.end());
      if (distances.empty() || distances[0].second != i || distances[0].first > limits.max_distance) continue;
      const int second = distances.size() > 1 ? distances[1].first : 257;
      if (distances[0].first > limits.max_ratio * second || distances[0].first >= best.distance) continue;
      best = {window.subject, i, distances[0].first};
    }
    if (best.distance <= 256) matches.push_back(best);
  }
  return matches;
}

TEST(MatchInWindows, EqualsBruteForce) {
  Random random(3);
  const Drawing drawing = random_drawing(random, 150);
  const FeatureGrid grid = drawing.grid();
  std::vector<Descriptor> descriptors;
  for (int k = 0; k < 200; ++k)
    descriptors.push_back(
        flipped(drawing.features.descriptors[random.below(150)], static_cast<int>(random.below(100))));
  std::vector<SearchWindow> windows;
  for (std::uint32_t k = 0; k < descriptors.size(); ++k) {
    windows.push_back(random_window(random, descriptors[k]));
    windows.back().subject = k;
    windows.back().radius *= 4.0F;
  }
  const MatchLimits limits{.max_distance = 110, .max_ratio = 0.95};
  const auto matches = match_in_windows(grid, windows, limits), expected = compare_all(grid, windows, limits);
  ASSERT_EQ(matches.size(), expected.size());
  EXPECT_GT(matches.size(), 20U);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EXPECT_EQ(matches[i].feature, expected[i].feature);
    EXPECT_EQ(matches[i].subject, expected[i].subject);
    EXPECT_EQ(matches[i].distance, expected[i].distance);
  }
}

TEST(MatchInWindows, TheSecondBestMayBeAsNearAsTheRatioAllows) {
  Random random(9);
  const Descriptor descriptor = random_descriptor(random);
  Drawing drawing;
  drawing.add(100.0F, 100.0F, 0, flipped(descriptor, 10));
  drawing.add(104.0F, 100.0F, 0, flipped(descriptor, 20));
  const FeatureGrid grid = drawing.grid();
  const std::vector<SearchWindow> windows = {{3, 102.0F, 100.0F, 5.0F, nan, 0, 7, &descriptor}};
  for (const auto& [ratio, found] : {std::pair{0.5, true}, {0.49, false}})
    EXPECT_EQ(match_in_windows(grid, windows, {.max_distance = 10, .max_ratio = ratio}).size(), found ? 1U : 0U);
  EXPECT_TRUE(match_in_windows(grid, windows, {.max_distance = 9, .max_ratio = 1.0}).empty());
}

TEST(MatchWithinRadius, MatchesFeaturesThatMovedLessThanTheRadius) {
  Random random(4);
  const Descriptor near = random_descriptor(random), far = random_descriptor(random);
  Drawing first, second;
  first.add(100.0F, 100.0F, 2, near);
  first.add(300.0F, 200.0F, 2, far);
  second.add(360.0F, 200.0F, 2, far);
  second.add(130.0F, 90.0F, 3, flipped(near, 10));
  const MatchLimits limits;
  EXPECT_THAT(match_within_radius(first.grid(), second.grid(), 40.0F, limits), ElementsAre(Pair(0U, 1U)));
  EXPECT_THAT(match_within_radius(first.grid(), second.grid(), 80.0F, limits), ElementsAre(Pair(0U, 1U), Pair(1U, 0U)));
}

/// A landmark 4 m in front of a camera at the origin, in the right half of the image at level 3.
class GuidedSearchTest : public ::testing::Test {
 protected:
  static constexpr double baseline = 0.1;
  GuidedSearchTest() {
    drawing_.add(pixel().x() + 2.0F, pixel().y() - 1.0F, 3, flipped(descriptor_, 5), pixel().x() - 12.5F);
    // As similar, but outside the window or at another level.
    drawing_.add(pixel().x() + 40.0F, pixel().y(), 3, descriptor_);
    drawing_.add(pixel().x(), pixel().y(), 6, descriptor_);
  }

  Eigen::Vector2f pixel() const { return vga().project(position_)->cast<float>(); }
  LandmarkAppearance landmark() const {
    const double max_distance = position_.norm() * std::pow(1.2, 3);
    return {position_, direction_, static_cast<float>(max_distance / std::pow(1.2, 7)),
            static_cast<float>(max_distance), descriptor_};
  }
  GuidedSearch search(const FeatureGrid& grid, double baseline_m = 0.0) const {
    return {camera_, grid, std::vector<float>(8, 5.0F), {.baseline = baseline_m}};
  }

  Camera camera_ = vga();
  Eigen::Vector3d position_{0.8, 0.4, 4.0}, direction_ = position_.normalized();
  Descriptor descriptor_ = [] {
    Random random(5);
    return random_descriptor(random);
  }();
  Drawing drawing_;
};

TEST_F(GuidedSearchTest, FindsALandmarkWhereItIsProjectedAtItsLevel) {
  const FeatureGrid grid = drawing_.grid();
  GuidedSearch guided = search(grid);
  EXPECT_TRUE(guided.add_landmark(9, landmark(), position_, Eigen::Vector3d::Zero()));
  const auto matches = guided.match({});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].subject, 9U);
  EXPECT_EQ(matches[0].feature, 0U);
  EXPECT_EQ(matches[0].distance, 5);
}

TEST_F(GuidedSearchTest, LeavesOutLandmarksThatAreNotVisibleOrWouldLookDifferent) {
  const FeatureGrid grid = drawing_.grid();
  GuidedSearch guided = search(grid);
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  EXPECT_FALSE(guided.add_landmark(0, landmark(), -position_, origin)) << "behind the camera";
  EXPECT_FALSE(guided.add_landmark(0, landmark(), {8.0, 0.0, 4.0}, origin)) << "outside the image";
  EXPECT_FALSE(guided.add_landmark(0, landmark(), position_, position_ - 3.0 * position_)) << "too far";
  EXPECT_FALSE(guided.add_landmark(0, landmark(), position_, position_ - 0.2 * position_)) << "too near";
  EXPECT_FALSE(guided.add_landmark(0, landmark(), position_, 2.0 * position_)) << "from behind";
  EXPECT_FALSE(guided.add_point(0, {0.0, 0.0, 0.0}, 3, descriptor_));
  EXPECT_FALSE(guided.add_point(0, {nan, 0.0, 1.0}, 3, descriptor_));
  EXPECT_THAT(guided.match({}), IsEmpty());
}

TEST_F(GuidedSearchTest, SearchesTheLevelOfTheDistance) {
  const FeatureGrid grid = drawing_.grid();
  for (const auto& [share, found] : {std::pair{1.0, true}, {1.2, true}, {1.5, false}, {0.84, true}, {0.6, false}}) {
    // The camera moves back and forth along the ray: the same pixel, another level.
    GuidedSearch guided = search(grid);
    ASSERT_TRUE(guided.add_landmark(0, landmark(), share * position_, position_ - share * position_)) << share;
    const auto matches = guided.match({});
    EXPECT_EQ(std::any_of(matches.begin(), matches.end(), [](const FeatureMatch& m) { return m.feature == 0; }), found)
        << share;
  }
}

TEST_F(GuidedSearchTest, TheRightCameraMustAgreeIfItIsChecked) {
  const FeatureGrid grid = drawing_.grid();  // 12.5 px are a tenth of a meter at 4 m
  for (const auto& [baseline_m, found] : {std::pair{0.0, true}, {baseline, true}, {3.0 * baseline, false}}) {
    GuidedSearch guided = search(grid, baseline_m);
    EXPECT_TRUE(guided.add_landmark(0, landmark(), position_, Eigen::Vector3d::Zero()));
    EXPECT_EQ(guided.match({}).size(), found ? 1U : 0U) << baseline_m;
  }
}

TEST_F(GuidedSearchTest, SearchesEverywhereWithoutAPrediction) {
  Drawing drawing;
  drawing.add(3.0F, 470.0F, 7, flipped(descriptor_, 20));
  const FeatureGrid grid = drawing.grid();
  GuidedSearch guided = search(grid);
  guided.add_anywhere(4, descriptor_);
  const auto matches = guided.match({});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].subject, 4U);
}

TEST_F(GuidedSearchTest, ALevelBeyondTheCoarsestIsTheCoarsest) {
  drawing_.add(pixel().x() + 3.0F, pixel().y(), 7, flipped(descriptor_, 2));
  const FeatureGrid grid = drawing_.grid();
  for (const int level : {7, 8, 9}) {
    GuidedSearch guided = search(grid);
    ASSERT_TRUE(guided.add_point(0, position_, level, descriptor_));
    const auto matches = guided.match({.max_distance = 10});
    ASSERT_EQ(matches.size(), 1U) << level;
    EXPECT_EQ(matches[0].feature, 2U) << "level 6 is the most similar one there";
  }
}

}  // namespace
}  // namespace rastro
