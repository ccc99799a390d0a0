// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/word_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "rastro/backend/descriptor_testing.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

using ::testing::ElementsAre;
using testing::flipped;
using ::testing::IsEmpty;
using ::testing::Pair;
using testing::random_descriptor;

/// Descriptors and the node of each.
struct Image {
  void add(const Descriptor& descriptor, std::uint32_t node) {
    descriptors.push_back(descriptor);
    words.nodes.push_back(node);
  }
  WordedFeatures features() const { return {descriptors, words, use}; }

  std::vector<Descriptor> descriptors;
  BagOfWords words;
  std::vector<std::uint8_t> use;
};

class WordMatching : public ::testing::Test {
 protected:
  Random random_{1};
  Descriptor a_ = random_descriptor(random_), b_ = random_descriptor(random_);
  Image first_, second_;
};

TEST_F(WordMatching, OnlyFeaturesOfOneNodeAreCompared) {
  first_.add(a_, 1);
  first_.add(b_, 2);
  second_.add(b_, 1);
  second_.add(flipped(a_, 9), 1);
  second_.add(flipped(b_, 3), 2);
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {}), ElementsAre(Pair(0, 1), Pair(1, 2)));
}

TEST_F(WordMatching, LimitsAreInclusive) {
  first_.add(a_, 1);
  second_.add(flipped(a_, 40), 1);
  EXPECT_EQ(match_by_words(first_.features(), second_.features(), {.max_distance = 40}).size(), 1U);
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {.max_distance = 39}), IsEmpty());
  second_.add(flipped(a_, 50), 1);
  EXPECT_EQ(match_by_words(first_.features(), second_.features(), {.max_ratio = 0.8}).size(), 1U);
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {.max_ratio = 0.79}), IsEmpty());
}

TEST_F(WordMatching, EachIsTheOthersMostSimilar) {
  first_.add(flipped(a_, 6), 1);
  first_.add(flipped(a_, 2), 1);
  second_.add(a_, 1);
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {}), ElementsAre(Pair(1, 0)));
  EXPECT_THAT(match_by_words(second_.features(), first_.features(), {}), ElementsAre(Pair(0, 1)));
}

TEST_F(WordMatching, UnusedFeaturesAreSkipped) {
  first_.add(flipped(a_, 6), 1);
  first_.add(flipped(a_, 2), 1);
  first_.use = {1, 0};
  second_.add(a_, 1);
  second_.add(flipped(a_, 1), 1);
  second_.use = {1, 0};
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {}), ElementsAre(Pair(0, 0)));
  first_.use = {0, 0};
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {}), IsEmpty());
}

TEST_F(WordMatching, WithoutFeaturesOrNodesThereAreNone) {
  first_.add(a_, 1);
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {}), IsEmpty());
  second_.descriptors.push_back(a_);  // an image whose words are without nodes
  EXPECT_THAT(match_by_words(first_.features(), second_.features(), {}), IsEmpty());
}

/// Against brute-force matching.
TEST(WordMatchingOfMany, EqualsBruteForce) {
  Random random(4);
  std::size_t found = 0;
  for (int round = 0; round < 5; ++round) {
    Image first, second;
    for (int k = 0; k < 150; ++k) {
      const Descriptor descriptor = random_descriptor(random);
      first.add(descriptor, random.below(6));
      second.add(flipped(descriptor, static_cast<int>(random.below(90))),
                 random.below(4) > 0 ? first.words.nodes.back() : 7);
      first.use.push_back(random.below(5) > 0 ? 1 : 0);
    }
    const auto comparable = [&](std::size_t i, std::size_t j) {
      return first.use[i] != 0 && first.words.nodes[i] == second.words.nodes[j];
    };
    std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
    for (std::uint32_t i = 0; i < 150; ++i) {
      int best = 257, next = 257, best_back = 257;
      std::uint32_t to = 0, back = 0;
      for (std::uint32_t j = 0; j < 150; ++j) {
        if (!comparable(i, j)) continue;
        const int distance = hamming_distance(first.descriptors[i], second.descriptors[j]);
        if (distance < best) to = j;
        next = std::min(next, std::max(distance, best));
        best = std::min(best, distance);
      }
      if (best > 80 || best > 0.9 * next) continue;
      for (std::uint32_t k = 0; k < 150; ++k) {
        if (!comparable(k, to)) continue;
        const int distance = hamming_distance(first.descriptors[k], second.descriptors[to]);
        if (distance < best_back) back = k;
        best_back = std::min(best_back, distance);
      }
      if (back == i) expected.emplace_back(i, to);
    }
    const auto pairs = match_by_words(first.features(), second.features(), {.max_distance = 80, .max_ratio = 0.9});
    EXPECT_EQ(pairs, expected);
    EXPECT_EQ(pairs, match_by_words(first.features(), second.features(), {.max_distance = 80, .max_ratio = 0.9}));
    found += pairs.size();
  }
  EXPECT_GT(found, 200U);
}

}  // namespace
}  // namespace rastro
