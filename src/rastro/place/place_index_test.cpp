// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/place_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Some of 200 words with weights that sum to 1.
BagOfWords random_bag(Random& random, std::uint32_t words = 200) {
  BagOfWords bag;
  float sum = 0.0F;
  for (std::uint32_t word = 0; word < words; ++word) {
    if (random.below(8) != 0) continue;
    bag.words.emplace_back(word, static_cast<float>(random.uniform(0.1, 1.0)));
    sum += bag.words.back().second;
  }
  for (auto& [word, share] : bag.words) share /= sum;
  return bag;
}

/// 1 - |a - b|_1 / 2 over all words.
double plain_similarity(const BagOfWords& a, const BagOfWords& b) {
  std::map<std::uint32_t, double> difference;
  for (const auto& [word, share] : a.words) difference[word] += static_cast<double>(share);
  for (const auto& [word, share] : b.words) difference[word] -= static_cast<double>(share);
  double sum = 0.0;
  for (const auto& [word, value] : difference) sum += std::abs(value);
  return 1.0 - 0.5 * sum;
}

int plain_shared(const BagOfWords& a, const BagOfWords& b) {
  int shared = 0;
  for (const auto& [word, share] : a.words)
    shared += static_cast<int>(
        std::count_if(b.words.begin(), b.words.end(), [w = word](const auto& other) { return other.first == w; }));
  return shared;
}

TEST(BagSimilarity, IsTheOneNormOverAllWords) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const BagOfWords a = random_bag(random), b = random_bag(random);
    EXPECT_NEAR(similarity(a, b), plain_similarity(a, b), 1e-6);
    EXPECT_NEAR(similarity(a, b), similarity(b, a), 1e-9);
    EXPECT_NEAR(similarity(a, a), 1.0, 1e-6);
  }
  EXPECT_NEAR(similarity({{{1, 1.0F}}, {}}, {{{2, 1.0F}}, {}}), 0.0, 1e-9);
}

/// Against a comparison with every image.
TEST(PlaceIndexFind, EqualsComparingEveryImage) {
  Random random(2);
  PlaceIndex index;
  std::map<std::int64_t, BagOfWords> plain;
  for (int k = 0; k < 80; ++k) {
    const std::int64_t id = 1000 - 7 * k;  // in descending order
    plain[id] = random_bag(random);
    index.add(id, plain[id]);
  }
  for (int k = 0; k < 80; k += 3) {
    index.remove(1000 - 7 * k);
    plain.erase(1000 - 7 * k);
  }
  index.remove(12345);
  EXPECT_EQ(index.size(), plain.size());
  const auto even = [](std::int64_t id) { return id % 2 == 0; };
  for (int trial = 0; trial < 60; ++trial) {
    const BagOfWords asked = random_bag(random);
    const bool some = trial % 2 == 0;
    const double least_share = trial % 3 == 0 ? 0.5 : 0.9;
    int most = 0;
    for (const auto& [id, bag] : plain)
      if (!some || even(id)) most = std::max(most, plain_shared(asked, bag));
    std::vector<PlaceMatch> expected;
    for (const auto& [id, bag] : plain) {
      const int shared = plain_shared(asked, bag);
      if ((some && !even(id)) || shared == 0 || shared < least_share * most) continue;
      expected.push_back({id, shared, plain_similarity(asked, bag)});
    }
    const auto found = index.find(asked, least_share, some ? even : std::function<bool(std::int64_t)>());
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (i > 0) {
        EXPECT_GE(found[i - 1].score, found[i].score) << "highest score first";
      }
      const auto same = std::find_if(expected.begin(), expected.end(),
                                     [&](const PlaceMatch& match) { return match.id == found[i].id; });
      ASSERT_NE(same, expected.end()) << found[i].id;
      EXPECT_EQ(found[i].shared_words, same->shared_words);
      EXPECT_NEAR(found[i].score, same->score, 1e-6);
    }
  }
}

/// The index sums what similarity() does, word by word: results do not depend on which of them was asked.
TEST(PlaceIndexFind, ScoresAreThoseOfSimilarityToTheLastBit) {
  Random random(4);
  PlaceIndex index;
  for (int id = 0; id < 60; ++id) index.add(id, random_bag(random));
  for (int id = 0; id < 60; id += 4) index.remove(id);
  for (int id = 60; id < 70; ++id) index.add(id, random_bag(random));  // in the slots that were left
  for (int trial = 0; trial < 40; ++trial) {
    const BagOfWords asked = random_bag(random);
    const auto found = index.find(asked, 0.0);
    EXPECT_GT(found.size(), 40U);
    for (const PlaceMatch& match : found) EXPECT_EQ(match.score, similarity(asked, *index.find_words(match.id)));
  }
}

TEST(PlaceIndexFind, EqualScoresAreInTheOrderOfTheirIds) {
  Random random(3);
  const BagOfWords bag = random_bag(random);
  PlaceIndex index;
  for (const std::int64_t id : {9, 2, 5}) index.add(id, bag);
  std::vector<std::int64_t> ids;
  for (const PlaceMatch& match : index.find(bag)) ids.push_back(match.id);
  EXPECT_EQ(ids, (std::vector<std::int64_t>{2, 5, 9}));
}

TEST(PlaceIndexFind, UnknownWordsFindNothing) {
  PlaceIndex index;
  EXPECT_TRUE(index.find({{{3, 1.0F}}, {}}).empty());
  index.add(1, {{{3, 0.5F}, {7, 0.5F}}, {}});
  EXPECT_TRUE(index.find({{{4, 1.0F}}, {}}).empty());
  EXPECT_TRUE(index.find({{{1000000, 1.0F}}, {}}).empty());
  EXPECT_TRUE(index.find({}).empty());
  EXPECT_EQ(index.find({{{7, 1.0F}}, {}}).size(), 1U);
  index.remove(1);
  EXPECT_TRUE(index.find({{{7, 1.0F}}, {}}).empty());
  EXPECT_EQ(index.find_words(1), nullptr);
  index.add(1, {{{4, 1.0F}}, {}});
  EXPECT_EQ(index.find({{{4, 1.0F}}, {}}).size(), 1U) << "and may be added again";
}

}  // namespace
}  // namespace rastro
