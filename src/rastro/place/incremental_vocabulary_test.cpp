// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/incremental_vocabulary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace rastro {
namespace {

Descriptor random_descriptor(std::mt19937_64& random) {
  Descriptor descriptor;
  for (auto& word : descriptor.words) word = random();
  return descriptor;
}

Descriptor with_flipped(Descriptor descriptor, int bits) {
  for (int bit = 0; bit < bits; ++bit) descriptor.words[static_cast<std::size_t>(bit) / 64] ^= 1ULL << (bit % 64);
  return descriptor;
}

std::vector<Descriptor> random_descriptors(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < count; ++i) descriptors.push_back(random_descriptor(random));
  return descriptors;
}

/// The definition: the nearest of all words, by distance and id, if it is clearly nearer than the second.
std::int64_t nearest_by_definition(const IncrementalVocabulary& vocabulary, const Descriptor& descriptor,
                                   double ratio) {
  std::vector<std::pair<int, std::int64_t>> all;
  for (std::int64_t word = 0; word < vocabulary.next_id(); ++word)
    if (vocabulary.contains(word)) all.emplace_back(hamming_distance(descriptor, vocabulary.descriptor(word)), word);
  std::sort(all.begin(), all.end());
  if (all.empty() || all[0].first > 128) return -1;
  const int second = std::min(128, all.size() > 1 ? all[1].first : 128);
  return all[0].first <= ratio * second ? all[0].second : -1;
}

TEST(IncrementalVocabulary, UnrelatedDescriptorsBecomeWordsAndSimilarOnesAreThem) {
  IncrementalVocabulary vocabulary;
  const std::vector<Descriptor> first = random_descriptors(50, 1);
  const std::vector<std::int64_t> words = vocabulary.add(first);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(words[i], static_cast<std::int64_t>(i));
  std::vector<Descriptor> again;
  for (const Descriptor& each : first) again.push_back(with_flipped(each, 20));
  EXPECT_EQ(vocabulary.find(again), words);
  EXPECT_EQ(vocabulary.add(again), words);
  EXPECT_EQ(vocabulary.size(), 50U);
  EXPECT_EQ(vocabulary.uses(7), 2);
}

TEST(IncrementalVocabulary, ASecondFeatureOfAnImageIsTheWordThatTheFirstMade) {
  IncrementalVocabulary vocabulary;
  const Descriptor one = random_descriptors(1, 2).front();
  EXPECT_EQ(vocabulary.add(std::vector{one, with_flipped(one, 9), one}), (std::vector<std::int64_t>{0, 0, 0}));
  EXPECT_EQ(vocabulary.uses(0), 3);
}

TEST(IncrementalVocabulary, TheDistanceRatioDecides) {
  const Descriptor one = random_descriptors(1, 3).front();
  for (const int bits : {102, 103}) {  // 0.8 of 128 is 102.4
    IncrementalVocabulary vocabulary(0.8);
    vocabulary.add(std::vector{one});
    EXPECT_EQ(vocabulary.find(std::vector{with_flipped(one, bits)}).front(), bits == 102 ? 0 : -1);
  }
  IncrementalVocabulary strict(0.0);
  EXPECT_EQ(strict.add(std::vector{one, with_flipped(one, 1), one}), (std::vector<std::int64_t>{0, 1, 0}));
}

TEST(IncrementalVocabulary, EqualsTheDefinitionWithWordsThatComeAndGoForAnyPool) {
  constexpr double ratio = 0.9;
  IncrementalVocabulary alone(ratio), shared(ratio);
  TaskPool pool(3);
  std::mt19937_64 random(5);
  std::vector<std::vector<std::int64_t>> images;
  for (int image = 0; image < 12; ++image) {
    std::vector<Descriptor> descriptors = random_descriptors(40, static_cast<std::uint64_t>(image % 5));
    for (Descriptor& each : descriptors) each = with_flipped(each, static_cast<int>(random() % 110));
    const std::vector<std::int64_t> found = alone.find(descriptors);
    for (std::size_t i = 0; i < descriptors.size(); ++i)
      EXPECT_EQ(found[i], nearest_by_definition(alone, descriptors[i], ratio));
    EXPECT_EQ(shared.find(descriptors, &pool), found);
    images.push_back(alone.add(descriptors));
    EXPECT_EQ(shared.add(descriptors, &pool), images.back());
    if (image % 3 == 2) {
      alone.release(images[static_cast<std::size_t>(image) - 1]);
      shared.release(images[static_cast<std::size_t>(image) - 1]);
    }
    EXPECT_EQ(shared.size(), alone.size());
  }
}

TEST(IncrementalVocabulary, WordsWithoutUsesAreForgottenAndComeBackAsTheyWere) {
  IncrementalVocabulary vocabulary;
  const std::vector<Descriptor> first = random_descriptors(6, 7);
  const std::vector<std::int64_t> words = vocabulary.add(first);
  vocabulary.add(std::vector{first[2]});
  vocabulary.release(words);
  vocabulary.release(std::vector<std::int64_t>{-1});
  EXPECT_EQ(vocabulary.size(), 1U);
  EXPECT_TRUE(vocabulary.contains(2));
  EXPECT_EQ(vocabulary.find(std::vector{first[1]}).front(), -1);
  EXPECT_EQ(vocabulary.add(random_descriptors(1, 8)).front(), 6) << "no id is given twice";
  vocabulary.restore(words, first);
  EXPECT_EQ(vocabulary.size(), 7U);
  EXPECT_EQ(vocabulary.find(first), words);
  EXPECT_EQ(vocabulary.uses(2), 2);
  EXPECT_EQ(vocabulary.descriptor(4), first[4]);
  IncrementalVocabulary loaded;
  loaded.restore(words, first);
  EXPECT_EQ(loaded.next_id(), 6);
}

}  // namespace
}  // namespace rastro
