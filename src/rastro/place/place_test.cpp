// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/simd_testing.h"
#include "rastro/place/place_index.h"

namespace rastro {
namespace {

using ::testing::HasSubstr;

Descriptor flipped(Descriptor descriptor, int bits, Random& random) {
  for (int i = 0; i < bits; ++i) {
    const auto bit = random.below(256);
    descriptor.words[bit / 64] ^= std::uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

/// Places made of features of their own: a feature is a descriptor that is observed with a few bits changed.
class Places {
 public:
  explicit Places(int places, std::uint64_t seed = 1) : random_(seed), things_(static_cast<std::size_t>(places)) {
    for (auto& of : things_)
      for (int i = 0; i < 60; ++i) of.push_back({{random_.next(), random_.next(), random_.next(), random_.next()}});
  }
  std::vector<Descriptor> image(std::size_t place) {
    std::vector<Descriptor> seen;
    for (const Descriptor& thing : things_[place])
      if (random_.uniform() < 0.8) seen.push_back(flipped(thing, 6, random_));
    return seen;
  }
  std::vector<std::vector<Descriptor>> images(int of_each) {
    std::vector<std::vector<Descriptor>> all;
    for (std::size_t place = 0; place < things_.size(); ++place)
      for (int i = 0; i < of_each; ++i) all.push_back(image(place));
    return all;
  }

 private:
  Random random_;
  std::vector<std::vector<Descriptor>> things_;
};

const Vocabulary& trained() {
  static const Vocabulary vocabulary = Vocabulary::train(Places(12).images(5), {8, 3, 12, 1});
  return vocabulary;
}

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Vocabulary, DistinguishesPlaces) {
  Places places(12);
  double least_same = 1.0, most_other = 0.0;
  for (std::size_t a = 0; a < 12; ++a) {
    const BagOfWords words = trained().words_of(places.image(a));
    for (std::size_t b = 0; b < 12; ++b) {
      const double alike = similarity(words, trained().words_of(places.image(b)));
      if (a == b) least_same = std::min(least_same, alike);
      if (a != b) most_other = std::max(most_other, alike);
    }
  }
  EXPECT_GT(least_same, 0.4);
  EXPECT_LT(most_other, 0.2);
}

TEST(Vocabulary, BagsHaveAscendingWordsAndUnitSum) {
  Places places(12);
  const auto image = places.image(3);
  const BagOfWords bag = trained().words_of(image, 2);
  ASSERT_EQ(bag.nodes.size(), image.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < bag.words.size(); ++i) {
    sum += static_cast<double>(bag.words[i].second);
    EXPECT_LT(bag.words[i].first, trained().words());
    EXPECT_TRUE(i == 0 || bag.words[i - 1].first < bag.words[i].first);
  }
  EXPECT_NEAR(sum, 1.0, 1e-5);
  EXPECT_DOUBLE_EQ(similarity(bag, {}), 0.0);
  EXPECT_NEAR(similarity(bag, bag), 1.0, 1e-5);
  EXPECT_LE(std::set<std::uint32_t>(bag.nodes.begin(), bag.nodes.end()).size(), 8U * 8U);
  const std::set<std::uint32_t> coarse = [&] {
    const auto nodes = trained().words_of(image, 1).nodes;
    return std::set<std::uint32_t>(nodes.begin(), nodes.end());
  }();
  EXPECT_LE(coarse.size(), 8U);
  EXPECT_TRUE(trained().words_of({}).words.empty());
}

TEST(Vocabulary, IsTheSameForAnyPoolAndCode) {
  const auto images = Places(6).images(4);
  TaskPool pool(3);
  const std::string bytes = Vocabulary::train(images, {}).bytes();
  EXPECT_EQ(bytes, Vocabulary::train(images, {}, &pool).bytes());
  EXPECT_EQ(bytes, rastro::testing::with_plain_code([&] { return Vocabulary::train(images, {}).bytes(); }));
  EXPECT_NE(bytes, Vocabulary::train(images, {10, 5, 12, 2}).bytes());
}

TEST(Vocabulary, TrainsFromIdenticalAndFewDescriptors) {
  const std::vector<std::vector<Descriptor>> alike(3, std::vector<Descriptor>(50));
  EXPECT_EQ(Vocabulary::train(alike, {}).words(), 1U);
  EXPECT_THAT(error_of([] { Vocabulary::train({}, {}); }), HasSubstr("no descriptors to train from"));
  EXPECT_THAT(error_of([&] { Vocabulary::train(alike, {1, 5, 12, 1}); }), HasSubstr("branching 1 is out of range"));
}

TEST(Vocabulary, SavesAndLoads) {
  const auto file = scratch_path("v.rvoc");
  trained().write(file);
  const Vocabulary back = Vocabulary::read(file);
  EXPECT_EQ(back.bytes(), trained().bytes());
  Places places(12);
  const auto image = places.image(0);
  EXPECT_EQ(back.words_of(image).words, trained().words_of(image).words);
  EXPECT_EQ(back.words_of(image).nodes, trained().words_of(image).nodes);
}

TEST(Vocabulary, RefusesAnyDamagedFile) {
  const std::string bytes = Vocabulary::train(Places(2).images(2), {3, 2, 12, 1}).bytes();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    EXPECT_NE(error_of([&] { Vocabulary::parse(damaged, "v.rvoc"); }), "no error") << i;
    EXPECT_NE(error_of([&] { Vocabulary::parse(std::string_view(bytes).substr(0, i), "v.rvoc"); }), "no error") << i;
  }
  EXPECT_NE(error_of([&] { Vocabulary::parse(bytes + "x", "v.rvoc"); }), "no error");
}

/// A node in the text form; all 32 bytes are equal.
std::string node_line(int parent, bool is_word, int byte, double weight) {
  std::string line = std::to_string(parent) + (is_word ? " 1" : " 0");
  for (int i = 0; i < 32; ++i) line += " " + std::to_string(byte);
  return line + " " + std::to_string(weight) + "\n";
}

std::string yaml_node(int id, int parent, int byte, double weight, const std::string& before) {
  std::string text = "      - { nodeId:" + std::to_string(id) + ", parentId:" + std::to_string(parent) +
                     ", weight:" + std::to_string(weight) + ",\n          descriptor:\"" + before;
  for (int i = 0; i < 32; ++i) text += std::to_string(byte) + " ";
  return text + "\" }\n";
}

TEST(Vocabulary, ReadsTextAndYaml) {
  const std::string lines = "2 2 0 0 \n" + node_line(0, false, 0, 0) + node_line(0, true, 255, 3.0) +
                            node_line(1, true, 0, 1.0) + node_line(1, true, 15, 2.0);
  std::vector<std::string> forms = {lines};
  for (const char* before : {"", "dbw3 0 32 "})
    forms.push_back("%YAML:1.0\nvocabulary:\n   k: 2\n   L: 2\n   scoringType: 0\n   weightingType: 0\n   nodes:\n" +
                    yaml_node(1, 0, 0, 0, before) + yaml_node(2, 0, 255, 3.0, before) +
                    yaml_node(3, 1, 0, 1.0, before) + yaml_node(4, 1, 15, 2.0, before) +
                    "   words:\n      - { wordId:1, nodeId:4 }\n      - { wordId:0, nodeId:3 }\n");
  Descriptor black, white;
  white.words.fill(~std::uint64_t{0});
  for (const std::string& form : forms) {
    const Vocabulary vocabulary = Vocabulary::parse(form, "voc");
    EXPECT_EQ(vocabulary.words(), 3U);
    EXPECT_EQ(vocabulary.depth(), 2);
    const BagOfWords bag = vocabulary.words_of(std::vector{black, white}, 1);
    ASSERT_EQ(bag.words.size(), 2U);
    EXPECT_NE(bag.nodes[0], bag.nodes[1]);
    EXPECT_FLOAT_EQ(std::min(bag.words[0].second, bag.words[1].second), 0.25F);  // Weights of 1 and 3.
  }
}

TEST(Vocabulary, RefusesBrokenText) {
  const std::string good = "2 2 0 0\n" + node_line(0, true, 0, 1) + node_line(0, true, 9, 1);
  EXPECT_EQ(error_of([&] { Vocabulary::parse(good, "voc"); }), "no error");
  EXPECT_THAT(error_of([&] { Vocabulary::parse(good + node_line(7, true, 9, 1), "voc"); }),
              HasSubstr("are not connected to the root"));
  EXPECT_THAT(error_of([&] { Vocabulary::parse(good + "0 1 3 4\n", "voc"); }), HasSubstr("voc:4"));
  EXPECT_THAT(error_of([&] { Vocabulary::parse(good + node_line(2, true, 0, 1) + node_line(3, true, 0, 1), "voc"); }),
              HasSubstr("deeper"));
  EXPECT_THAT(error_of([] { Vocabulary::parse("an image", "voc"); }), HasSubstr("is not a vocabulary"));
  EXPECT_THAT(error_of([] { Vocabulary::parse("", "voc"); }), HasSubstr("has no words"));
}

TEST(StandardVocabulary, IsThere) {
  const auto vocabulary = standard_vocabulary();
  EXPECT_GT(vocabulary->words(), 20000U);
  EXPECT_EQ(vocabulary.get(), standard_vocabulary().get());
}

TEST(PlaceIndex, FindsThePlace) {
  Places places(12);
  PlaceIndex index;
  for (std::int64_t id = 0; id < 36; ++id)
    index.add(id, trained().words_of(places.image(static_cast<std::size_t>(id / 3))));
  for (std::size_t place = 0; place < 12; ++place) {
    const BagOfWords asked = trained().words_of(places.image(place));
    const auto matches = index.find(asked, 0.0);
    ASSERT_GE(matches.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(static_cast<std::size_t>(matches[i].id / 3), place);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      EXPECT_DOUBLE_EQ(matches[i].score, similarity(asked, *index.find_words(matches[i].id)));
      EXPECT_TRUE(i == 0 || matches[i - 1].score >= matches[i].score);
    }
    EXPECT_LE(index.find(asked, 0.8).size(), 3U);
    for (const PlaceMatch& match : index.find(asked, 0.0, [](std::int64_t id) { return id % 2 == 0; }))
      EXPECT_EQ(match.id % 2, 0);
  }
}

TEST(PlaceIndex, DoesNotFindRemovedImages) {
  Places places(4);
  PlaceIndex index;
  const BagOfWords first = trained().words_of(places.image(0));
  index.add(7, first);
  index.add(3, first);
  const auto both = index.find(first);
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].id, 3);  // Equal scores are sorted by id.
  EXPECT_EQ(both[0].shared_words, static_cast<int>(first.words.size()));
  index.remove(3);
  index.remove(99);
  ASSERT_EQ(index.find(first).size(), 1U);
  EXPECT_EQ(index.find(first)[0].id, 7);
  EXPECT_FALSE(index.contains(3));
  EXPECT_EQ(index.find_words(3), nullptr);
  EXPECT_TRUE(index.find({}).empty());
}

}  // namespace
}  // namespace rastro
