// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/descriptor_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

Features random_floats(Random& random, int count) {
  Features features;
  features.length = 8;
  features.keypoints.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count * 8; ++i) features.floats.push_back(static_cast<float>(random.uniform(-1, 1)));
  return features;
}

Features random_bits(Random& random, int count) {
  Features features;
  features.keypoints.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    features.descriptors.push_back({{random.next(), random.next(), random.next(), random.next()}});
  return features;
}

float distance_of(const Features& a, std::size_t i, const Features& b, std::size_t k) {
  if (a.binary()) return static_cast<float>(hamming_distance(a.descriptors[i], b.descriptors[k]));
  double sum = 0.0;
  for (std::size_t d = 0; d < 8; ++d) {
    const auto difference = static_cast<double>(a.floats[8 * i + d]) - static_cast<double>(b.floats[8 * k + d]);
    sum += difference * difference;
  }
  return static_cast<float>(std::sqrt(sum));
}

/// By definition, one pair after the other.
std::vector<DescriptorMatch> slow_matches(const Features& a, const Features& b, const DescriptorMatchOptions& options) {
  const auto nearest = [](const Features& from, std::size_t i, const Features& to) {
    std::vector<std::pair<float, std::size_t>> all;
    for (std::size_t k = 0; k < to.size(); ++k) all.emplace_back(distance_of(from, i, to, k), k);
    std::sort(all.begin(), all.end());
    return all;
  };
  std::vector<DescriptorMatch> result;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto there = nearest(a, i, b);
    if (options.mutual && nearest(b, there[0].second, a)[0].second != i) continue;
    if (there[0].first >= static_cast<float>(options.max_ratio) * there[1].first) continue;
    result.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(there[0].second), there[0].first});
  }
  return result;
}

TEST(MatchDescriptors, EqualsOneByOneComparison) {
  Random random(1);
  for (const bool binary : {false, true}) {
    const auto a = binary ? random_bits(random, 150) : random_floats(random, 150);
    const auto b = binary ? random_bits(random, 170) : random_floats(random, 170);
    for (const bool mutual : {false, true}) {
      const DescriptorMatchOptions options{.max_ratio = binary ? 0.97 : 0.85, .mutual = mutual};
      const auto expected = slow_matches(a, b, options), found = match_descriptors(a, b, options);
      ASSERT_GT(expected.size(), 5U);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].first, expected[i].first);
        EXPECT_EQ(found[i].second, expected[i].second);
        EXPECT_NEAR(found[i].distance, expected[i].distance, 1e-4);
      }
    }
  }
}

TEST(MatchDescriptors, DoesNotDependOnThePool) {
  Random random(2);
  const auto a = random_floats(random, 300), b = random_floats(random, 300);
  const DescriptorMatchOptions options{.max_ratio = 1.0};
  const auto alone = match_descriptors(a, b, options);
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    const auto together = match_descriptors(a, b, options, &pool);
    ASSERT_EQ(together.size(), alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(together[i].second, alone[i].second);
      EXPECT_EQ(together[i].distance, alone[i].distance);
    }
  }
}

TEST(MatchDescriptors, OfEqualDistancesTheSmallerIndexWins) {
  Features a, b;
  a.keypoints.resize(2);
  a.descriptors.resize(2);
  b.keypoints.resize(3);
  b.descriptors.resize(3);
  const auto matches = match_descriptors(a, b, {.max_ratio = 1.0});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].first, 0U);
  EXPECT_EQ(matches[0].second, 0U);
  EXPECT_TRUE(match_descriptors(a, b, {.max_ratio = 0.8}).empty());  // repeated texture is ambiguous
}

TEST(MatchDescriptors, MatchesAreWithinTheMaximumDistance) {
  Features a, b;
  a.keypoints.resize(1);
  b.keypoints.resize(1);
  a.descriptors.push_back({{0, 0, 0, 0}});
  b.descriptors.push_back({{0xFF, 0, 0, 0}});
  EXPECT_EQ(match_descriptors(a, b, {.max_distance = 8.0}).size(), 1U);
  EXPECT_TRUE(match_descriptors(a, b, {.max_distance = 7.0}).empty());
}

TEST(MatchDescriptors, EmptySetsDoNotMatchAndKindsDoNotMix) {
  Random random(3);
  const auto floats = random_floats(random, 5);
  EXPECT_TRUE(match_descriptors({}, floats, {}).empty());
  EXPECT_TRUE(match_descriptors(floats, {}, {}).empty());
  EXPECT_THROW(match_descriptors(floats, random_bits(random, 5), {}), Error);
}

}  // namespace
}  // namespace rastro
