// SPDX-License-Identifier: Apache-2.0
// What holds exactly at a limit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "rastro/backend/acceptance.h"
#include "rastro/backend/guided_search.h"
#include "rastro/backend/loop_candidates.h"
#include "rastro/backend/map_uncertainty.h"

namespace rastro {
namespace {

Camera round_camera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  return camera;
}

FeatureGrid grid_with(const Camera& camera, const std::vector<Eigen::Vector2f>& pixels,
                      const std::vector<float>& rights) {
  Features features;
  features.keypoints.resize(pixels.size());
  features.levels.assign(pixels.size(), 0);
  features.descriptors.resize(pixels.size());
  return {camera, std::make_shared<const Features>(std::move(features)), pixels, rights};
}

constexpr float unknown_right = std::numeric_limits<float>::quiet_NaN();

TEST(AtEquality, ACorrectionOfTheLimitIsNotLittle) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const MapCorrection moved{1, SE3(SO3(), {0.25, 0.0, 0.0}), zero},
      turned{1, SE3(SO3::exp({0.0, 0.0, 0.125}), zero), zero};
  const double angle = turned.corrected_from_world.rotation().log().norm();
  using ::testing::ElementsAre;
  EXPECT_THAT(agreeing({&moved, 1}, {0.25, 1.0}), ElementsAre(0));
  EXPECT_THAT(agreeing({&moved, 1}, {0.2500001, 1.0}), ElementsAre(1));
  EXPECT_THAT(agreeing({&moved, 1}, {0.2500001, 0.0}), ElementsAre(0)) << "no rotation is not less than none";
  EXPECT_THAT(agreeing({&turned, 1}, {1.0, angle}), ElementsAre(0));
  EXPECT_THAT(agreeing({&turned, 1}, {1.0, 1.0001 * angle}), ElementsAre(1));
  EXPECT_THAT(agreeing({&turned, 1}, {0.0, 1.0}), ElementsAre(0));
}

TEST(AtEquality, APointIsFoundWithinItsWindowAndNotBehindTheLeastDepth) {
  const Camera camera = round_camera();
  const Descriptor descriptor;
  const auto found = [&](const Eigen::Vector2f& pixel, float right, double baseline) {
    const FeatureGrid grid = grid_with(camera, {pixel}, {right});
    GuidedSearch search(camera, grid, {5.0F}, {.baseline = baseline});
    EXPECT_TRUE(search.add_point(0, {0.0, 0.0, 2.0}, 0, descriptor));
    return !search.match({}).empty();
  };
  for (const float off : {-5.0F, 5.0F}) {
    EXPECT_TRUE(found({320.0F + off, 240.0F}, unknown_right, 0.0));
    EXPECT_TRUE(found({320.0F, 240.0F + off}, unknown_right, 0.0));
    EXPECT_TRUE(found({320.0F, 240.0F}, 270.0F + off, 0.2)) << "at 320 - 500 * 0.2 / 2";
  }
  EXPECT_TRUE(found({320.0F, 240.0F}, 17.0F, 0.0)) << "without a baseline the right pixel does not matter";
  const FeatureGrid grid = grid_with(camera, {{320.0F, 240.0F}}, {unknown_right});
  GuidedSearch search(camera, grid, {5.0F}, {.min_view_cosine = -1.0});
  const Eigen::Vector3d position(0.0, 0.0, 2.0), direction = Eigen::Vector3d::UnitZ();
  for (const auto& [depth, visible] : {std::pair{1e-6, false}, {1.01e-6, true}, {-1.0, false}}) {
    EXPECT_EQ(search.add_point(0, {0.0, 0.0, depth}, 0, descriptor), visible) << depth;
    const LandmarkAppearance landmark{position, direction, 0.1F, 9.0F, descriptor};
    EXPECT_EQ(search.add_landmark(0, landmark, {0.0, 0.0, depth}, {0.0, 0.0, 0.0}), visible) << depth;
  }
}

TEST(AtEquality, ALandmarkIsSearchedForAtTheEndsOfItsDistancesAndAtTheAngle) {
  const Camera camera = round_camera();
  const FeatureGrid grid = grid_with(camera, {{320.0F, 240.0F}}, {unknown_right});
  const Descriptor descriptor;
  GuidedSearch search(camera, grid, {5.0F}, {.min_view_cosine = 0.5});
  // At the origin, seen along x, shown from 1 m to 4 m.
  const Eigen::Vector3d position = Eigen::Vector3d::Zero(), direction = Eigen::Vector3d::UnitX();
  const LandmarkAppearance landmark{position, direction, 1.0F, 4.0F, descriptor};
  const auto searched = [&](const Eigen::Vector3d& center) {
    return search.add_landmark(0, landmark, {0.0, 0.0, 1.0}, center);
  };
  EXPECT_TRUE(searched({-0.8, 0.0, 0.0}));
  EXPECT_FALSE(searched({-0.7999, 0.0, 0.0}));
  EXPECT_TRUE(searched({-5.0, 0.0, 0.0}));
  EXPECT_FALSE(searched({-5.0001, 0.0, 0.0}));
  for (const auto& [cosine, seen] : {std::pair{3.0 / 5.0, true}, {0.6001, false}}) {
    GuidedSearch narrow(camera, grid, {5.0F}, {.min_view_cosine = cosine});
    EXPECT_EQ(narrow.add_landmark(0, landmark, {0.0, 0.0, 1.0}, {-3.0, 4.0, 0.0}), seen) << cosine;
  }
}

TEST(AtEquality, OfEquallySimilarFeaturesTheFirstIsTheBestAndTheNextTheSecond) {
  const Camera camera = round_camera();
  const FeatureGrid grid = grid_with(camera, {{320.0F, 240.0F}, {321.0F, 240.0F}}, {unknown_right, unknown_right});
  const Descriptor descriptor;
  const std::vector<SearchWindow> windows = {{7, 320.0F, 240.0F, 5.0F, unknown_right, 0, 7, &descriptor}};
  const auto matches = match_in_windows(grid, windows, {.max_distance = 0, .max_ratio = 0.0});
  ASSERT_EQ(matches.size(), 1U) << "a distance of 0 is none of any second";
  EXPECT_EQ(matches.front().feature, 0U);
}

TEST(AtEquality, AFeatureOnTheRimOfAllIsFoundByAWindowThatJustReachesIt) {
  Camera camera = round_camera();
  camera.width = 0;  // the bounds are those of the features
  const FeatureGrid grid = grid_with(camera, {{-20.0F, 50.0F}, {300.0F, 90.0F}}, {unknown_right, unknown_right});
  std::vector<std::uint32_t> found;
  grid.find(-25.0F, 50.0F, 5.0F, 0, 0, found);
  EXPECT_EQ(found.size(), 1U);
  grid.find(-20.0F, 45.0F, 5.0F, 0, 0, found);
  EXPECT_EQ(found.size(), 1U);
  grid.find(305.0F, 95.0F, 5.0F, 0, 0, found);
  EXPECT_EQ(found.size(), 1U);
}

BagOfWords words_of(std::initializer_list<std::uint32_t> words) {
  BagOfWords bag;
  for (const std::uint32_t word : words) bag.words.emplace_back(word, 1.0F / static_cast<float>(words.size()));
  return bag;
}

TEST(AtEquality, ACandidateMayHaveTheLeastScoreAndTheLeastShareOfTheBest) {
  PlaceIndex index;
  index.add(3, words_of({1, 2, 3, 4}));
  index.add(5, words_of({1, 2, 8, 9}));
  const BagOfWords words = words_of({1, 2, 3, 4});
  const auto any = [](std::int64_t) { return true; };
  const auto all = place_candidates(
      index, words, {.min_shared_words = 0.0, .min_score = 0.0, .min_share_of_best = 0.0, .max_candidates = 9}, any,
      nullptr);
  ASSERT_EQ(all.size(), 2U);
  const double best = all[0].score, other = all[1].score;
  const auto found = [&](double score, double share) {
    return place_candidates(
               index, words,
               {.min_shared_words = 0.0, .min_score = score, .min_share_of_best = share, .max_candidates = 9}, any,
               nullptr)
        .size();
  };
  EXPECT_EQ(found(other, 0.0), 2U);
  EXPECT_EQ(found(other * (1.0 + 1e-9), 0.0), 1U);
  EXPECT_EQ(found(0.0, 1.0), 1U) << "the best itself";
  EXPECT_EQ(found(0.0, other / best), 2U);
}

TEST(AtEquality, WhatIsAsUncertainIsNotTakenOver) {
  MapUncertainty uncertainty;
  Matrix6d first = Matrix6d::Zero(), second = first;
  first(0, 0) = second(1, 1) = 0.25;
  uncertainty.set(1, Eigen::Vector3d::Zero(), first);
  uncertainty.reduce(1, Eigen::Vector3d::Zero(), second);
  EXPECT_EQ(uncertainty.of_pose(1, Eigen::Vector3d::Zero(), Matrix6d::Zero()), first);
}

TEST(AtEquality, AChosenNumberIsOneOfThoseBeforeTheEnd) {
  using ::testing::ElementsAre;
  LoopCandidates candidates(6);
  for (const std::int64_t id : {-1, 0, 5, 6}) candidates.add(id);
  EXPECT_THAT(candidates.ids(), ElementsAre(0, 5));
  candidates.add_nearest({{0.0, -1}, {0.1, 6}, {0.2, 0}, {0.3, 4}, {0.4, 3}}, 1);
  EXPECT_THAT(candidates.ids(), ElementsAre(0, 5, 4));
  Random random(1);
  candidates.add_random({-1, 0, 6, 2}, 5, random);
  EXPECT_THAT(candidates.ids(), ElementsAre(0, 5, 4, 2));
}

}  // namespace
}  // namespace rastro
