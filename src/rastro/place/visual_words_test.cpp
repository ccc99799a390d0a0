// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/visual_words.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

Features real_features(int count, int length, std::uint64_t seed) {
  Random random(seed);
  Features features;
  features.length = length;
  features.keypoints.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count * length; ++i) features.floats.push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
  return features;
}

Descriptor random_descriptor(Random& random) {
  Descriptor descriptor;
  for (auto& word : descriptor.words) word = random.next();
  return descriptor;
}

/// With `flips` bits changed, or fewer.
Descriptor noisy(Descriptor descriptor, int flips, Random& random) {
  for (int i = 0; i < flips; ++i) descriptor.words[random.below(4)] ^= std::uint64_t{1} << random.below(64);
  return descriptor;
}

TEST(VisualWords, RealFeaturesOfAnyScaleAndLengthHaveWords) {
  for (const int length : {64, 128}) {
    VisualWords words(0.8);
    Features seen = real_features(50, length, 1);
    const auto first = words.add(seen, 50);
    EXPECT_EQ(std::set(first.begin(), first.end()).size(), 50U) << length;
    for (float& value : seen.floats) value *= 3.0F;
    EXPECT_EQ(words.add(seen, 50), first) << "brighter";
    const auto others = words.add(real_features(50, length, 2), 50);
    for (const std::int64_t word : others) EXPECT_GE(word, 50) << length;
  }
}

TEST(VisualWords, ComeBackAsTheyWere) {
  VisualWords words(0.8);
  const Features seen = real_features(20, 64, 3);
  const auto first = words.add(seen, 20);
  words.release(first);
  EXPECT_EQ(words.size(), 0U);
  words.restore(first, seen);
  EXPECT_EQ(words.add(seen, 20), first);
}

TEST(IncrementalVocabulary, FindsTheWordsOfNoisyFeaturesAmongMany) {
  constexpr int count = 20000;
  Random random(5);
  IncrementalVocabulary vocabulary;
  std::vector<Descriptor> all;
  for (int i = 0; i < count; ++i) all.push_back(random_descriptor(random));
  for (int i = 0; i < count; i += 500)
    EXPECT_EQ(vocabulary.add(std::span(all).subspan(static_cast<std::size_t>(i), 500)).front(), i);
  EXPECT_LT(vocabulary.comparisons(), 2000U) << "of 20000";
  std::vector<Descriptor> seen;
  for (int i = 0; i < count; i += 20) seen.push_back(noisy(all[static_cast<std::size_t>(i)], 20, random));
  const auto found = vocabulary.find(seen);
  int right = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    right += found[i] == static_cast<std::int64_t>(20 * i) ? 1 : 0;
    EXPECT_TRUE(found[i] == -1 || found[i] == static_cast<std::int64_t>(20 * i)) << "never another one";
  }
  EXPECT_GT(right, 850) << "of 1000, though nothing is worse to search than random descriptors";
}

/// With a million words, all at once would take seconds.
TEST(IncrementalVocabulary, WordsMoveToNewBucketsLittleByLittleAndAreFoundAllTheWhile) {
  constexpr std::size_t at_once = 200, most_moved = 512;
  Random random(9);
  IncrementalVocabulary vocabulary;
  std::vector<Descriptor> all;
  std::vector<std::int64_t> words;
  std::size_t most_moving = 0, before = 0;
  for (int image = 0; image < 44; ++image) {
    std::vector<Descriptor> seen;
    for (std::size_t i = 0; i < at_once; ++i) seen.push_back(random_descriptor(random));
    const std::int64_t next = words.empty() ? 0 : words.back() + 1;
    const auto added = vocabulary.add(seen);
    for (std::size_t i = 0; i < at_once; ++i) {
      if (added[i] < next || (!words.empty() && added[i] <= words.back())) continue;  // like another one by chance
      all.push_back(seen[i]);
      words.push_back(added[i]);
    }
    const std::size_t moving = vocabulary.moving();
    if (before > 0) {
      EXPECT_EQ(moving, before - std::min(before, most_moved)) << image;
    }
    most_moving = std::max(most_moving, std::exchange(before, moving));
    if (image % 4 == 0) {
      ASSERT_EQ(vocabulary.find(all), words) << image;
    }
  }
  EXPECT_GT(most_moving, 3000U);
  for (std::size_t calls = vocabulary.moving() / most_moved + 1; calls > 0; --calls) vocabulary.release({});
  EXPECT_EQ(vocabulary.moving(), 0U);
  EXPECT_EQ(vocabulary.find(all), words);
}

TEST(IncrementalVocabulary, KeepsItsWordsWhenBucketsAreMadeAnew) {
  Random random(6);
  IncrementalVocabulary vocabulary;
  std::vector<Descriptor> all;
  for (int i = 0; i < 9000; ++i) all.push_back(random_descriptor(random));
  const auto words = vocabulary.add(all);
  vocabulary.add(std::span(all).first(10));
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(vocabulary.descriptor(words[i]), all[i]) << i;
    ASSERT_EQ(vocabulary.uses(words[i]), i < 10 ? 2 : 1) << i;
  }
  vocabulary.release(std::span(words).subspan(100));
  EXPECT_EQ(vocabulary.size(), 100U);
  EXPECT_EQ(vocabulary.find(std::span(all).first(100)), std::vector(words.begin(), words.begin() + 100));
}

}  // namespace
}  // namespace rastro
