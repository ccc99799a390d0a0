// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/word_kinds.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "rastro/base/random.h"
#include "rastro/export/word_map_testing.h"

namespace rastro {
namespace {

using testing::ElementsAre;
using enum WordKind;

TEST(WordKinds, OfAHandmadeMap) {
  const Map map = WordMap()
                      .add({1, 2, 2, 3})
                      .add({2, 3, 4, 4, -1, 5})       // 2 and 3 are in the previous image
                      .add({1, 1, 6, 3, 7, 7})        // 1 is known, and there twice
                      .add({3, 1, 6, 8, 4, 9, 9, 5})  // closes a loop with the second
                      .close(1, 3, 20)
                      .made();
  const auto locations = words_of_locations(map);
  ASSERT_EQ(locations.size(), 4U);
  EXPECT_THAT(locations[0].kinds, ElementsAre(fresh, repeated, repeated, fresh));
  EXPECT_THAT(locations[1].kinds, ElementsAre(previous, previous, repeated, repeated, std::nullopt, fresh));
  EXPECT_THAT(locations[2].kinds, ElementsAre(repeated, repeated, fresh, previous, repeated, repeated))
      << "word 3 is of the location just before, word 1 of the first";
  EXPECT_THAT(locations[3].kinds, ElementsAre(shared, previous, previous, fresh, shared, repeated, repeated, shared));
  EXPECT_EQ(locations[3].matched, 1);
  EXPECT_EQ(locations[3].closure->inliers, 20);
  EXPECT_THAT(locations[3].counts(), ElementsAre(0, 1, 2, 2, 3));
  EXPECT_FALSE(locations[2].closure);
}

TEST(WordKinds, AWordOfAnEarlierLocationIsKnown) {
  const auto locations = words_of_locations(WordMap().add({1, 2}).add({3}).add({2, 4}).made());
  EXPECT_THAT(locations[2].kinds, ElementsAre(known, fresh));
}

TEST(WordKinds, RehearsedKeyframesBelongToTheLocationBefore) {
  const Map map = WordMap()
                      .add({1, 2})
                      .add({}, 0.0)
                      .add({3, 4})
                      .add({}, 0.0)
                      .add({}, 1.0)  // a bad signature: a location without words
                      .close(1, 3, 12)
                      .made();
  const auto locations = words_of_locations(map);
  ASSERT_EQ(locations.size(), 3U);
  EXPECT_EQ(locations[1].location, 2);
  EXPECT_EQ(locations[1].matched, 0) << "the keyframes of the constraint are others of the same two locations";
  EXPECT_EQ(locations[1].closure->from, 1);
  EXPECT_EQ(locations[2].location, 4);
  EXPECT_TRUE(locations[2].kinds.empty());
}

TEST(WordKinds, TheMatchIsTheLoopClosureWithTheMostInliers) {
  WordMap map;
  for (int k = 0; k < 5; ++k) map.add({k});
  map.close(0, 4, 10).close(1, 4, 30).close(4, 2, 30);  // found later with as many
  map.close(3, 4, 90, ConstraintKind::odometry).close(0, 3, 80, ConstraintKind::proximity);
  auto locations = words_of_locations(map.made());
  EXPECT_EQ(locations[4].matched, 1);
  EXPECT_FALSE(locations[3].closure) << "odometry and neighbors close no loop";
  EXPECT_FALSE(locations[2].closure) << "it is the earlier one";
  locations = words_of_locations(map.close(4, 2, 31, ConstraintKind::merge).made());
  EXPECT_EQ(locations[4].matched, 2);
  EXPECT_EQ(locations[4].closure->kind, ConstraintKind::merge);
}

TEST(WordKinds, TheMatchedImageHasSharedWordsAndKnownOnes) {
  const std::vector<std::int64_t> later = {3, 5, -1}, earlier = {5, 4, -1, 3, 3};
  EXPECT_THAT(kinds_seen_from(later, earlier), ElementsAre(shared, known, std::nullopt, shared, shared));
}

TEST(WordKinds, AMapWithoutSignaturesHasNoLocations) { EXPECT_TRUE(words_of_locations(Map()).empty()); }

/// The definition of each color read word by word over all images.
WordKind expected_kind(const std::vector<std::vector<std::int64_t>>& all, std::size_t at, std::int64_t word,
                       std::size_t matched) {
  const auto uses = [&](std::size_t image) { return std::count(all[image].begin(), all[image].end(), word); };
  if (matched < at && uses(matched) > 0) return shared;
  if (at > 0 && uses(at - 1) > 0) return previous;
  if (uses(at) > 1) return repeated;
  for (std::size_t k = 0; k < at; ++k)
    if (uses(k) > 0) return known;
  return fresh;
}

TEST(WordKinds, AgreeWithTheDefinitionOnRandomMaps) {
  Random random(7);
  WordMap map;
  std::vector<std::vector<std::int64_t>> all(40);
  for (auto& words : all) {
    for (int k = 0; k < 12; ++k) words.push_back(static_cast<std::int64_t>(random.uniform(0.0, 60.0)));
    map.add(words);
  }
  for (KeyframeId id = 10; id < 40; id += 3) map.close(id / 2, id, 25);
  const auto locations = words_of_locations(map.made());
  ASSERT_EQ(locations.size(), all.size());
  for (std::size_t at = 0; at < all.size(); ++at) {
    const std::size_t matched = at >= 10 && (at - 10) % 3 == 0 ? at / 2 : all.size();
    for (std::size_t k = 0; k < all[at].size(); ++k)
      EXPECT_EQ(locations[at].kinds[k], expected_kind(all, at, all[at][k], matched)) << at << ' ' << k;
  }
}

}  // namespace
}  // namespace rastro
