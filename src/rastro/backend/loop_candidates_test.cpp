// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/loop_candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace rastro {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Ids = std::vector<std::int64_t>;

/// As if from an image: words and their counts.
BagOfWords bag(const std::map<std::uint32_t, int>& counts) {
  BagOfWords result;
  float sum = 0.0F;
  for (const auto& [word, count] : counts) sum += static_cast<float>(count);
  for (const auto& [word, count] : counts) result.words.emplace_back(word, static_cast<float>(count) / sum);
  return result;
}

/// A corridor of places with four words each, two of which the next one also has.
class Corridor : public ::testing::Test {
 protected:
  Corridor() {
    for (std::int64_t id = 0; id < 20; ++id) index_.add(id, at(id));
  }

  static BagOfWords at(std::int64_t place) {
    const auto first = static_cast<std::uint32_t>(2 * place);
    return bag({{first, 1}, {first + 1, 1}, {first + 2, 1}, {first + 3, 1}});
  }
  static GroupOf next_to() {
    return [](std::int64_t id) { return Ids{id - 1, id + 1}; };
  }

  PlaceIndex index_;
};

Ids ids_of(const std::vector<PlaceCandidate>& candidates) {
  Ids ids;
  for (const PlaceCandidate& candidate : candidates) ids.push_back(candidate.id);
  return ids;
}

TEST_F(Corridor, TheMostSimilarComeFirstThenByIdAndNoMoreThanAskedFor) {
  const PlaceCandidateOptions all{.min_shared_words = 0.0, .max_candidates = 9};
  const auto found = place_candidates(index_, at(8), all);
  ASSERT_THAT(ids_of(found), ElementsAre(8, 7, 9));
  EXPECT_NEAR(found[0].score, 1.0, 1e-6);
  EXPECT_NEAR(found[1].score, 0.5, 1e-6);
  EXPECT_THAT(ids_of(place_candidates(index_, at(8), {.min_shared_words = 0.0, .max_candidates = 2})),
              ElementsAre(8, 7));
  EXPECT_THAT(place_candidates(index_, at(8), {.max_candidates = 0}), IsEmpty());
  EXPECT_THAT(place_candidates(index_, bag({{99, 1}}), all), IsEmpty());
  EXPECT_THAT(place_candidates(PlaceIndex(), at(8), all), IsEmpty());
}

TEST_F(Corridor, EachLimitLeavesOutWhatIsBelowIt) {
  EXPECT_THAT(ids_of(place_candidates(index_, at(8), {.min_shared_words = 0.51})), ElementsAre(8));
  EXPECT_THAT(ids_of(place_candidates(index_, at(8), {.min_shared_words = 0.0, .min_score = 0.51})), ElementsAre(8));
  EXPECT_THAT(ids_of(place_candidates(index_, at(8), {.min_shared_words = 0.0, .min_score = 0.49})),
              ElementsAre(8, 7, 9));
  EXPECT_THAT(ids_of(place_candidates(index_, at(8), {.min_shared_words = 0.0, .min_share_of_best = 0.51})),
              ElementsAre(8));
}

/// Keyframes that are connected already or too recent do not count, not even as the best that others are compared with.
TEST_F(Corridor, KeyframesThatAreNotAllowedDoNotCount) {
  const PlaceCandidateOptions options{.min_shared_words = 0.8, .min_share_of_best = 0.9};
  EXPECT_THAT(ids_of(place_candidates(index_, at(8), options, [](std::int64_t id) { return id != 8; })),
              ElementsAre(7, 9));
  EXPECT_THAT(place_candidates(index_, at(8), options, [](std::int64_t) { return false; }), IsEmpty());
}

TEST_F(Corridor, APlaceSeenFromSeveralKeyframesCountsMoreThanAChanceSimilarity) {
  // As similar as place 8, but alone.
  const BagOfWords query = bag({{16, 1}, {17, 1}, {18, 1}, {70, 1}});
  index_.add(50, bag({{16, 1}, {17, 1}, {18, 1}, {71, 1}}));
  const PlaceCandidateOptions options{.min_shared_words = 0.0, .min_share_of_best = 0.75};
  EXPECT_THAT(ids_of(place_candidates(index_, query, options)), ElementsAre(8, 50));
  const auto found = place_candidates(index_, query, options, {}, next_to());
  ASSERT_THAT(ids_of(found), ElementsAre(8)) << "its neighbors stand behind it, and by it";
  const double sum = similarity(query, at(7)) + similarity(query, at(8)) + similarity(query, at(9));
  EXPECT_NEAR(found[0].score, sum, 1e-9);
}

/// Random bags and groups, against the definition.
TEST(PlaceCandidates, AreThoseOfTheDefinition) {
  Random random(3);
  PlaceIndex index;
  std::map<std::int64_t, BagOfWords> bags;
  const auto random_bag = [&] {
    std::map<std::uint32_t, int> counts;
    while (counts.size() < 6) counts[random.below(30)] = 1 + static_cast<int>(random.below(3));
    return bag(counts);
  };
  for (std::int64_t id = 0; id < 60; ++id) index.add(id, bags[id] = random_bag());
  const GroupOf group_of = [](std::int64_t id) { return Ids{(id + 7) % 60, (id + 53) % 60}; };
  const PlaceCandidateOptions options{.min_shared_words = 0.5, .min_share_of_best = 0.6, .max_candidates = 60};
  std::size_t found = 0;
  for (int k = 0; k < 50; ++k) {
    const BagOfWords query = random_bag();
    std::map<std::int64_t, double> scores, sums;
    for (const PlaceMatch& match : index.find(query, options.min_shared_words)) scores[match.id] = match.score;
    for (const auto& [id, score] : scores) {
      Ids group = group_of(id);
      std::erase_if(group, [&](std::int64_t other) { return !scores.contains(other); });
      group.insert(group.begin(), id);
      double sum = 0.0;
      for (const std::int64_t other : group) sum += similarity(query, bags[other]);
      const std::int64_t best = *std::max_element(
          group.begin(), group.end(), [&](std::int64_t a, std::int64_t b) { return scores[a] < scores[b]; });
      sums[best] = std::max(sums[best], sum);
    }
    double best_sum = 0.0;
    for (const auto& [id, sum] : sums) best_sum = std::max(best_sum, sum);
    std::erase_if(sums, [&](const auto& entry) { return entry.second < 0.6 * best_sum; });
    const auto candidates = place_candidates(index, query, options, {}, group_of);
    ASSERT_EQ(candidates.size(), sums.size()) << k;
    for (const PlaceCandidate& candidate : candidates) EXPECT_NEAR(candidate.score, sums.at(candidate.id), 1e-9);
    EXPECT_TRUE(std::is_sorted(candidates.begin(), candidates.end(),
                               [](const auto& a, const auto& b) { return a.score > b.score; }));
    EXPECT_EQ(candidates, place_candidates(index, query, options, {}, group_of));
    found += candidates.size();
  }
  EXPECT_GT(found, 100U);
}

TEST_F(Corridor, LowestSimilarityIsThatOfTheLeastSimilarNeighbor) {
  EXPECT_NEAR(lowest_similarity(index_, at(8), Ids{8}), 1.0, 1e-6);
  EXPECT_NEAR(lowest_similarity(index_, at(8), Ids{8, 9, 7}), 0.5, 1e-6);
  EXPECT_NEAR(lowest_similarity(index_, at(8), Ids{8, 9, 15}), 0.0, 1e-6);
  EXPECT_EQ(lowest_similarity(index_, at(8), Ids{}), 0.0) << "nothing to compare with: anything may be a candidate";
}

TEST(LoopCandidates, TakeEachOnceAndOnlyExistingOnes) {
  LoopCandidates candidates(10);
  for (const std::int64_t id : {3, 12, 3, -1, 10, 9, 0}) candidates.add(id);
  EXPECT_EQ(candidates.ids(), (Ids{3, 9, 0}));
  EXPECT_TRUE(candidates.is_chosen(9));
  EXPECT_FALSE(candidates.is_chosen(12));
  EXPECT_EQ(candidates.free([](std::int64_t id) { return id % 3 == 0; }), Ids{6});
}

TEST(LoopCandidates, TheLatestDescendToTheFirst) {
  LoopCandidates candidates(10);
  candidates.add(8);
  candidates.add_latest(10, 3);
  EXPECT_EQ(candidates.ids(), (Ids{8, 9, 7}));
  candidates.add_latest(2, 5);
  EXPECT_EQ(candidates.ids(), (Ids{8, 9, 7, 1, 0}));
  candidates.add_latest(10, -1);
  EXPECT_EQ(candidates.ids().size(), 5U);
}

TEST(LoopCandidates, TheNearestAreCountedBesidesThoseChosen) {
  LoopCandidates candidates(10);
  candidates.add(4);
  candidates.add_nearest({{0.5, 7}, {0.1, 4}, {0.5, 2}, {0.2, 30}, {0.9, 1}}, 2);
  EXPECT_EQ(candidates.ids(), (Ids{4, 2, 7})) << "equal ones by id";
  candidates.add_nearest({{0.1, 3}}, 0);
  EXPECT_EQ(candidates.ids().size(), 3U);
  // Past the last one nothing may be read, whatever is in memory there.
  std::vector<std::pair<double, std::int64_t>> shrunk = {{0.1, 5}, {0.2, 6}};
  shrunk.pop_back();
  candidates.add_nearest(std::move(shrunk), 5);
  EXPECT_EQ(candidates.ids(), (Ids{4, 2, 7, 5}));
}

TEST(LoopCandidates, RandomOnesAreDistinctAscendingAndTheSameForASeed) {
  const Ids all{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 40};
  std::vector<int> times(10, 0);
  constexpr int draws = 1000;
  for (std::uint64_t seed = 0; seed < draws; ++seed) {
    Random random(seed), again(seed);
    LoopCandidates candidates(10), repeated(10);
    candidates.add(5);
    repeated.add(5);
    candidates.add_random(all, 3, random);
    repeated.add_random(all, 3, again);
    ASSERT_EQ(candidates.ids(), repeated.ids());
    ASSERT_EQ(candidates.ids().size(), 4U);
    ASSERT_TRUE(std::is_sorted(candidates.ids().begin() + 1, candidates.ids().end()));
    for (const std::int64_t id : candidates.ids()) ++times[static_cast<std::size_t>(id)];
  }
  EXPECT_EQ(times[5], draws);
  times.erase(times.begin() + 5);
  // 333 each on average, with a standard deviation of 15.
  for (const int count : times) EXPECT_NEAR(count, draws / 3, 70);
}

TEST(LoopCandidates, WhereFewAreLeftAllAreTaken) {
  Random random(1);
  LoopCandidates candidates(10);
  candidates.add_random({6, 2}, 5, random);
  EXPECT_EQ(candidates.ids(), (Ids{2, 6}));
  candidates.add_random({}, 5, random);
  candidates.add_random({1}, -1, random);
  EXPECT_EQ(candidates.ids().size(), 2U);
}

TEST(ShareOfReach, IsTheLargerOfPositionAndRotation) {
  const SE3 relative(SO3::exp({0.0, 0.35, 0.0}), {0.0, 0.0, -0.25});
  EXPECT_NEAR(share_of_reach(relative, 1.0, 0.7), 0.5, 1e-12);
  EXPECT_NEAR(share_of_reach(relative, 0.25, 0.7), 1.0, 1e-12);
  EXPECT_NEAR(share_of_reach(relative.inverse(), 1.0, 0.7), 0.5, 1e-12);
  EXPECT_EQ(share_of_reach(SE3(), 1.0, 0.7), 0.0);
}

/// Random graphs, against Floyd and Warshall's shortest paths.
TEST(WithinSteps, AreTheNodesOfAllShorterPaths) {
  constexpr std::size_t count = 40;
  constexpr int far = 1000;
  Random random(5);
  std::vector<Ids> neighbors(count);
  std::vector<std::vector<int>> steps(count, std::vector<int>(count, far));
  for (std::size_t k = 0; k < count; ++k) steps[k][k] = 0;
  for (int edge = 0; edge < 45; ++edge) {
    const std::size_t a = random.below(count), b = random.below(count);
    neighbors[a].push_back(static_cast<std::int64_t>(b));
    neighbors[b].push_back(static_cast<std::int64_t>(a));
    if (a != b) steps[a][b] = steps[b][a] = 1;
  }
  for (std::size_t via = 0; via < count; ++via)
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = 0; b < count; ++b) steps[a][b] = std::min(steps[a][b], steps[a][via] + steps[via][b]);
  const auto for_each_neighbor = [&](std::int64_t node, const auto& visit) {
    for (const std::int64_t other : neighbors[static_cast<std::size_t>(node)]) visit(other);
  };
  for (const int most : {0, 1, 3, 100}) {
    for (std::size_t from = 0; from < count; ++from) {
      Ids expected;
      for (std::size_t to = 0; to < count; ++to)
        if (steps[from][to] <= most) expected.push_back(static_cast<std::int64_t>(to));
      EXPECT_EQ(within_steps(static_cast<std::int64_t>(from), most, for_each_neighbor), expected) << from;
    }
  }
}

}  // namespace
}  // namespace rastro
