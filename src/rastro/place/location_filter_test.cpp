// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/location_filter.h"

#include <gtest/gtest.h>

#include <array>
#include <span>

#include <cmath>
#include <numeric>

namespace rastro {
namespace {

using Words = std::vector<std::int64_t>;

/// Locations 0, 1, 2... along a path.
std::span<const std::int64_t> along_path(std::int64_t location) {
  static std::array<std::int64_t, 2> links;  // until the next call
  links = {location - 1, location + 1};
  return links;
}

std::vector<LocationScore> equal_scores(int count, double score = 1.0) {
  std::vector<LocationScore> scores;
  for (int i = 0; i < count; ++i) scores.push_back({i, score});
  return scores;
}

double sum_of(const LocationFilter::Belief& belief) {
  double sum = belief.new_place;
  for (const LocationScore& each : belief.locations) sum += each.score;
  return sum;
}

TEST(SharedWordRatio, CountsEachWordAsOftenAsBothHaveIt) {
  EXPECT_EQ(shared_word_ratio(Words{3, 1, 2, 1}, Words{1, 1, 1, 3, 9}), 3.0 / 5.0);
  EXPECT_EQ(shared_word_ratio(Words{1, 2}, Words{1, 2}), 1.0);
  EXPECT_EQ(shared_word_ratio(Words{1, 2}, Words{3}), 0.0);
  EXPECT_EQ(shared_word_ratio(Words{}, Words{3}), 0.0);
}

TEST(LocationIndex, ScoresAreTermFrequencyTimesInverseDocumentFrequency) {
  LocationIndex index;
  index.add(4, Words{1, 1, 2, 3});
  index.add(2, Words{2, 5});
  index.add(9, Words{});
  const auto scores = index.scores(Words{1, 2, 2, 7});
  ASSERT_EQ(scores.size(), 3U);
  EXPECT_EQ(scores[0].location, 2);
  EXPECT_NEAR(scores[0].score, 2 * (1.0 / 2) * std::log(3.0 / 2), 1e-12);
  EXPECT_EQ(scores[1].location, 4);
  EXPECT_NEAR(scores[1].score, (2.0 / 4) * std::log(3.0) + 2 * (1.0 / 4) * std::log(3.0 / 2), 1e-12);
  EXPECT_EQ(scores[2].score, 0.0);
}

TEST(LocationIndex, ARemovedLocationLeavesNoTrace) {
  LocationIndex index, without;
  index.add(1, Words{1, 2, 2});
  index.add(2, Words{2, 3});
  index.remove(1);
  index.remove(77);
  without.add(2, Words{2, 3});
  EXPECT_FALSE(index.contains(1));
  EXPECT_EQ(index.size(), 1U);
  index.add(3, Words{3, 4});
  without.add(3, Words{3, 4});
  const auto scores = index.scores(Words{1, 2, 4}), expected = without.scores(Words{1, 2, 4});
  ASSERT_EQ(scores.size(), expected.size());
  for (std::size_t i = 0; i < scores.size(); ++i) EXPECT_EQ(scores[i].score, expected[i].score);
}

TEST(RelativeLikelihood, IsThatOfTheEquations) {
  const std::vector<LocationScore> scores{{0, 1.0}, {1, 1.0}, {2, 4.0}, {3, 0.0}, {4, 2.0}};
  const double mean = 8.0 / 4, sigma = std::sqrt(22.0 / 4 - mean * mean);
  const RelativeLikelihood likelihood = relative_likelihood(scores);
  EXPECT_NEAR(likelihood.new_place, mean / sigma + 1.0, 1e-12);
  EXPECT_NEAR(likelihood.locations[2], (4.0 - sigma) / mean, 1e-12);
  for (const std::size_t other : {0U, 1U, 3U, 4U}) EXPECT_EQ(likelihood.locations[other], 1.0);
}

TEST(RelativeLikelihood, ScoresThatSayNothingGiveOne) {
  for (const auto& scores : {equal_scores(5), equal_scores(5, 0.0), equal_scores(1), equal_scores(0)}) {
    const RelativeLikelihood likelihood = relative_likelihood(scores);
    EXPECT_EQ(likelihood.new_place, 1.0);
    EXPECT_EQ(likelihood.locations, std::vector<double>(scores.size(), 1.0));
  }
}

TEST(LocationFilter, BeginsInANewPlaceAndStaysThereBetweenEqualScores) {
  LocationFilter filter;
  EXPECT_EQ(filter.belief().best(), nullptr);
  EXPECT_EQ(filter.update({}, along_path).new_place, 1.0);
  const auto& belief = filter.update(equal_scores(10), along_path);
  EXPECT_NEAR(belief.new_place, 0.9, 1e-12);
  for (const LocationScore& each : belief.locations) EXPECT_NEAR(each.score, 0.01, 1e-12);
}

TEST(LocationFilter, OneImageIsNotEnoughAndSeveralAlongThePathAre) {
  LocationFilter filter;
  for (int step = 0; step < 5; ++step) {
    std::vector<LocationScore> scores = equal_scores(200, 0.0);
    for (std::size_t i = 0; i < scores.size(); ++i) scores[i].score = 0.02 * static_cast<double>(i % 3);
    scores[static_cast<std::size_t>(50 + step)].score = 2.0;
    const auto& belief = filter.update(scores, along_path);
    EXPECT_NEAR(sum_of(belief), 1.0, 1e-12);
    EXPECT_EQ(belief.best()->location, 50 + step);
    EXPECT_EQ(belief.best()->score > 0.11, step > 0) << step << " " << belief.best()->score;
  }
}

TEST(LocationFilter, AKnownPlaceSpreadsToItsNeighborsByAGaussian) {
  LocationFilterOptions options;
  options.neighbor_reach = 2;
  options.least_spread = 0.0;
  LocationFilter filter(options);
  std::vector<LocationScore> scores = equal_scores(30, 0.1);
  scores[15].score = 10.0;
  scores[3].score = 0.2;
  double before = 0.0;
  for (int i = 0; i < 20; ++i) before = filter.update(scores, along_path).best()->score;
  std::vector<double> old;
  for (const LocationScore& each : filter.belief().locations) old.push_back(each.score);
  const auto& belief = filter.update(equal_scores(30), along_path);
  const double one = std::exp(-0.5 / (1.6 * 1.6)), two = std::exp(-0.5 * 4 / (1.6 * 1.6));
  const double all = 1.0 + 2 * one + 2 * two;
  const double expected = 0.9 * (old[15] + one * (old[14] + old[16]) + two * (old[13] + old[17])) / all +
                          0.1 * (1.0 - std::accumulate(old.begin(), old.end(), 0.0)) / 30.0;
  EXPECT_NEAR(belief.locations[15].score, expected, 1e-9);
  EXPECT_GT(before, 0.5);
}

/// It makes no difference to what is believed that the unlikely ones do not spread.
TEST(LocationFilter, WhatIsUnlikelyKeepsItsProbability) {
  LocationFilterOptions all, likely;
  all.least_spread = 0.0;
  LocationFilter exact(all), fast(likely);
  int asked = 0;
  const auto counted = [&asked](std::int64_t location) {
    ++asked;
    return along_path(location);
  };
  for (int step = 0; step < 12; ++step) {
    std::vector<LocationScore> scores = equal_scores(400, 0.0);
    for (std::size_t i = 0; i < scores.size(); ++i) scores[i].score = 0.02 * static_cast<double>(i % 3);
    scores[50 + static_cast<std::size_t>(step)].score = 2.0;
    const auto& expected = exact.update(scores, along_path);
    asked = 0;
    const auto& belief = fast.update(scores, counted);
    EXPECT_NEAR(sum_of(belief), 1.0, 1e-12);
    EXPECT_EQ(belief.best()->location, expected.best()->location);
    if (step > 2) {
      EXPECT_NEAR(belief.best()->score, expected.best()->score, 0.01) << step;
    }
    EXPECT_LT(asked, 25 * 16) << "of 400 locations with 16 around each";
  }
}

TEST(LocationFilter, ALocationThatIsGoneGivesItsProbabilityToANewPlace) {
  LocationFilter filter;
  std::vector<LocationScore> scores = equal_scores(30, 0.1);
  scores[3].score = 0.2;
  scores[15].score = 10.0;
  for (int i = 0; i < 20; ++i) filter.update(scores, along_path);
  std::vector<LocationScore> fewer = equal_scores(30);
  fewer.erase(fewer.begin() + 15);
  const double gone = filter.belief().locations[15].score, fresh = filter.belief().new_place;
  const auto& belief = filter.update(fewer, [](std::int64_t) { return std::span<const std::int64_t>{}; });
  EXPECT_NEAR(belief.new_place, 0.9 * (fresh + gone) + 0.1 * (1.0 - fresh - gone), 1e-9);
  EXPECT_NEAR(sum_of(belief), 1.0, 1e-12);
}

}  // namespace
}  // namespace rastro
