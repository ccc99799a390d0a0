// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/appearance_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/backend/descriptor_testing.h"
#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// No candidates but those by appearance.
RtabmapOptions appearance_only() {
  RtabmapOptions options;
  options.rgbd.last_candidates = options.rgbd.near_candidates = options.rgbd.graph_candidates = 0;
  options.short_term_size = options.similar_locations = 3;
  options.time_limit_ms = 1e6;
  return options;
}

RtabmapOptions working_memory_only() {
  RtabmapOptions options = appearance_only();
  options.similar_locations = 0;
  return options;
}

/// A walk along places that share a few features with the next, and some with any other. Plays the mapper: places are
/// the same where their numbers are.
class Walk {
 public:
  static constexpr int own = 54, shared = 6, common = 15;  // features of a place

  using Candidates = LoopSearch::Candidates;

  explicit Walk(const RtabmapOptions& options, TaskPool* pool = nullptr)
      : graph_(options.rgbd, 0), search_(options, {pool, false}) {}

  /// With `seen` of its own features, at most 54.
  Candidates visit(int place, int submap = 0, int seen = own) { return process(add(place, submap, seen), place); }
  /// A place that only looks like it.
  Candidates visit_like(int place) { return process(add(place, 0, own), -1); }
  /// Nothing to recognize anything by.
  Candidates visit_blank() { return process(keep(std::make_shared<ImageFeatures>(), -1, 0), -1); }
  Candidates visit_all(int first, int last) {
    Candidates candidates;
    for (int place = first; place <= last; ++place) candidates = visit(place);
    return candidates;
  }
  /// Until no more leaves; which those were.
  std::vector<std::int64_t> forget(double fill) {
    std::vector<std::int64_t> all;
    for (;;) {
      const auto leaving = search_.transfer(graph_, fill);
      if (leaving.empty()) return all;
      for (const std::int64_t id : leaving) graph_.forget_features(id);
      all.insert(all.end(), leaving.begin(), leaving.end());
    }
  }
  const AppearanceSearch& search() const { return search_; }
  const ImageFeatures& image(std::int64_t id) const { return *kept_[static_cast<std::size_t>(id)]; }
  MemoryStage stage(std::int64_t location) const { return search_.memory().at(location).stage; }

 private:
  Candidates process(std::int64_t id, int place) {
    Candidates candidates = search_.candidates(graph_, id);
    for (const auto* ids : {&candidates.places, &candidates.retrieve})
      for (const std::int64_t each : *ids) graph_.restore_features(kept_[static_cast<std::size_t>(each)]);
    std::vector<Constraint> accepted;
    for (const std::int64_t each : candidates.places)
      if (places_[static_cast<std::size_t>(each)] == place)
        accepted.push_back(testing::edge_of(each, id, SE3(), ConstraintKind::loop));
    search_.on_matched(graph_, id, candidates, accepted);
    return candidates;
  }

  static void add_features(ImageFeatures& image, int place, int count, std::uint64_t seed) {
    Random features(seed_for(seed, static_cast<std::uint64_t>(place)));
    for (int k = 0; k < count; ++k)
      image.features.descriptors.push_back(testing::flipped(testing::random_descriptor(features), k % 3));
  }

  std::int64_t add(int place, int submap, int seen) {
    auto image = std::make_shared<ImageFeatures>();
    add_features(*image, place, seen, 1);
    add_features(*image, static_cast<int>(graph_.size()), own - seen, 4);
    add_features(*image, place, shared, 2);
    add_features(*image, place + 1, shared, 2);
    Random random(static_cast<std::uint64_t>(place));
    for (int k = 0; k < common; ++k) add_features(*image, static_cast<int>(random.below(40)), 1, 3);
    return keep(std::move(image), place, submap);
  }

  std::int64_t keep(std::shared_ptr<ImageFeatures> image, int place, int submap) {
    const std::int64_t id = image->id = graph_.size();
    image->features.keypoints.resize(image->features.descriptors.size());
    kept_.push_back(image);
    places_.push_back(place);
    graph_.add(image, {SE3(), submap}, Matrix6d::Zero());
    if (id > 0 && graph_.submap(id - 1) == submap) graph_.add_edge(testing::edge_of(id - 1, id, SE3()));
    return id;
  }

  KeyframeGraph graph_;
  AppearanceSearch search_;
  std::vector<std::shared_ptr<const ImageFeatures>> kept_;
  std::vector<int> places_;
};

TEST(AppearanceSearch, APlaceSeenAgainIsACandidateAndNewPlacesAreNone) {
  Walk walk(working_memory_only());
  for (int place = 0; place < 20; ++place) {
    EXPECT_THAT(walk.visit(place).places, IsEmpty()) << place;
    EXPECT_GT(walk.search().belief().new_place, 0.5) << place;
  }
  walk.visit_all(5, 6);
  EXPECT_THAT(walk.visit(7).places, Contains(7));
  ASSERT_NE(walk.search().belief().best(), nullptr);
  EXPECT_EQ(walk.search().belief().best()->location, 7);
  EXPECT_EQ(walk.search().memory().at(22).weight, 2.0) << "the newer one takes the weight";
  EXPECT_EQ(walk.search().memory().at(7).weight, 0.0);
}

TEST(AppearanceSearch, WordsThatNeverChangeRecognizeAPlaceAtOnce) {
  Walk walk(appearance_only());
  walk.visit_all(0, 19);
  EXPECT_THAT(walk.visit(5).places, Contains(5));
}

TEST(AppearanceSearch, ShortTermMemoryIsNotSearched) {
  RtabmapOptions options = appearance_only();
  options.short_term_size = 30;
  Walk walk(options);
  walk.visit_all(0, 19);
  EXPECT_THAT(walk.visit(5).places, IsEmpty());
}

TEST(AppearanceSearch, ALostFrameIsLookedForInShortTermMemoryToo) {
  RtabmapOptions options = appearance_only();
  options.short_term_size = 10;
  Walk walk(options);
  walk.visit_all(0, 19);
  for (const int place : {5, 15}) {
    const auto similar = walk.search().similar(walk.image(place));
    ASSERT_FALSE(similar.empty()) << place;
    EXPECT_EQ(similar.front(), place);
    EXPECT_LE(similar.size(), 8U);
  }
}

TEST(AppearanceSearch, ABudgetSmallerThanShortTermMemoryShortensIt) {
  RtabmapOptions options = appearance_only();
  options.short_term_size = 30;
  Walk walk(options);
  walk.visit_all(0, 9);
  EXPECT_THAT(walk.forget(0.5), IsEmpty());
  EXPECT_THAT(walk.forget(0.95), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8)) << "the last one stays";
  EXPECT_THAT(walk.visit(2).places, Contains(2)) << "and what left is recognized";
}

TEST(AppearanceSearch, WhatLooksLikeTheLastLocationIsRehearsed) {
  Walk walk(working_memory_only());
  for (const int place : {0, 1, 1, 1}) walk.visit(place);
  EXPECT_THAT(walk.search().memory().at(1).keyframes, ElementsAre(1, 2, 3));
  EXPECT_EQ(walk.search().memory().at(1).weight, 3.0);
}

/// The map has the weight of a location with all its keyframes.
TEST(AppearanceSearch, WeightsOfAGivenMapAreThoseItWasSavedWith) {
  AppearanceSearch search(RtabmapOptions(), {});
  Random features(7);
  for (std::int64_t id = 0; id < 3; ++id) {
    auto image = std::make_shared<ImageFeatures>();
    image->id = id;
    image->features.keypoints.resize(1);
    image->features.descriptors.push_back(testing::random_descriptor(features));
    const bool rehearsed = id == 1;
    search.know({image, rehearsed ? std::vector<std::int64_t>{} : std::vector<std::int64_t>{id}},
                rehearsed ? 0.0 : 2.0);
  }
  EXPECT_THAT(search.memory().at(0).keyframes, ElementsAre(0, 1));
  EXPECT_EQ(search.memory().at(0).weight, 2.0);
  EXPECT_EQ(search.memory().at(2).weight, 2.0);
}

TEST(AppearanceSearch, AForgottenPlaceComesBackWithItsNeighbors) {
  Walk walk(appearance_only());
  walk.visit_all(0, 19);
  EXPECT_THAT(walk.forget(1.0), ::testing::IsSupersetOf({3, 5, 6}));
  EXPECT_EQ(walk.stage(5), MemoryStage::long_term);
  const auto candidates = walk.visit(5);
  EXPECT_THAT(candidates.places, Contains(5));
  ASSERT_THAT(candidates.retrieve, SizeIs(2)) << "retrieved_neighbors";
  for (const std::int64_t location : {std::int64_t{5}, candidates.retrieve[0], candidates.retrieve[1]})
    EXPECT_EQ(walk.stage(location), MemoryStage::working) << location;
}

TEST(AppearanceSearch, WhatWasComparedInVainIsForgottenAgain) {
  Walk walk(appearance_only());
  walk.visit_all(0, 19);
  walk.forget(1.0);
  const auto candidates = walk.visit_like(5);
  EXPECT_THAT(candidates.places, Contains(5));
  EXPECT_EQ(walk.stage(5), MemoryStage::long_term);
  EXPECT_THAT(walk.forget(0.0), ::testing::IsSupersetOf({5})) << "though neither time nor memory is short";
}

TEST(AppearanceSearch, InThePaperOnlyWorkingMemoryIsSearched) {
  Walk walk(working_memory_only());
  walk.visit_all(0, 19);
  walk.forget(1.0);
  EXPECT_THAT(walk.visit(5).places, IsEmpty());
}

TEST(AppearanceSearch, WhatIsForgottenIsTheLightestThenTheOldest) {
  Walk walk(working_memory_only());
  walk.visit(0);
  for (int k = 0; k < 3; ++k) walk.visit(1);
  for (int place = 2; place < 12; ++place) walk.visit(place);
  const auto forgotten = walk.forget(1.0);
  EXPECT_THAT(forgotten, ElementsAre(0, 4, 5, 6, 7, 8, 9, 10, 1, 2, 3, 11, 12))
      << "the heaviest with all its keyframes last of working memory, then short-term memory";
}

TEST(AppearanceSearch, TransferKeepsTheTimeLimit) {
  RtabmapOptions options = working_memory_only();
  const auto work_ms = [&](double limit_ms) {
    options.time_limit_ms = limit_ms;
    Walk walk(options);
    double most_ms = 0.0;
    for (int place = 0; place < 150; ++place) {
      walk.visit(place);
      walk.forget(0.0);
      most_ms = std::max(most_ms, walk.search().work_ms());
    }
    return most_ms;
  };
  EXPECT_GT(work_ms(1e6), 0.3);
  const double limit_ms = 0.2, of_a_location_ms = 0.01;
  EXPECT_GT(work_ms(limit_ms), limit_ms) << "until then nothing leaves";
  EXPECT_LT(work_ms(limit_ms), limit_ms + of_a_location_ms);
}

TEST(AppearanceSearch, WordsOfWorkingMemoryAndLocationsTakeMemory) {
  const RtabmapOptions options = appearance_only();
  Walk walk(options);
  EXPECT_EQ(walk.search().bytes(), 0U);
  walk.visit_all(0, 19);
  const std::size_t before = walk.search().bytes();
  EXPECT_GT(before, 20U * 16U * static_cast<std::size_t>(options.rgbd.keyframe_features));
  const std::size_t lasting = walk.search().lasting_bytes();
  EXPECT_LT(lasting, before);
  walk.forget(1.0);
  EXPECT_LT(walk.search().bytes(), before);
  EXPECT_EQ(walk.search().lasting_bytes(), lasting) << "no location is lost";
}

/// Else working memory would shrink until nothing is recognized in it, and no match would be spared.
TEST(AppearanceSearch, MatchesAreNoWorkThatTransferShortens) {
  RtabmapOptions options = appearance_only();
  options.time_limit_ms = 1.0;
  Walk walk(options);
  walk.visit_all(0, 19);
  EXPECT_THAT(walk.visit(5).places, Contains(5));
  EXPECT_THAT(walk.forget(0.0), IsEmpty());
}

/// Place 6 comes back with place 5, so that its image adds no word; then its neighbors come back, with theirs.
TEST(AppearanceSearch, AsManyWordsAsComeBackAreTransferred) {
  RtabmapOptions options = appearance_only();
  options.hypotheses = 0;
  options.least_similarity = 1.0;
  options.time_limit_ms = 0.0;
  Walk walk(options);
  walk.visit_all(0, 12);
  walk.forget(1.0);
  walk.visit(5);
  walk.visit_all(30, 36);
  ASSERT_EQ(walk.stage(6), MemoryStage::working);
  ASSERT_THAT(walk.visit(6).retrieve, SizeIs(2));
  const std::size_t before = walk.search().memory().working().size();
  walk.forget(0.0);
  EXPECT_LE(walk.search().memory().working().size() + 2, before) << "one location alone has fewer words";
}

TEST(AppearanceSearch, AKeyframeWithTooFewFeaturesIsNotTheWorkOfTheOneBefore) {
  Walk walk(working_memory_only());
  walk.visit_all(0, 5);
  EXPECT_GT(walk.search().work_ms(), 0.0);
  walk.visit_blank();
  EXPECT_EQ(walk.search().work_ms(), 0.0);
}

/// A camera that comes often has most like what it sees among its own keyframes.
TEST(AppearanceSearch, APlaceInAnotherSubmapIsAlwaysCompared) {
  RtabmapOptions options = appearance_only();
  options.similar_locations = 1;
  options.hypotheses = 0;
  Walk walk(options);
  for (int place = 0; place < 5; ++place) walk.visit(place, 0, 25);
  for (const int place : {3, 10, 11, 12, 13, 3, 20, 21, 22, 23}) walk.visit(place, 1);
  EXPECT_THAT(walk.visit(3, 1).places, Contains(3));
}

TEST(AppearanceSearch, EveryRunDoesTheSameForAnyNumberOfThreads) {
  const auto told = [](TaskPool* pool) {
    RtabmapOptions options = appearance_only();
    options.time_limit_ms = 0.3;
    Walk walk(options, pool);
    std::string text;
    for (int k = 0; k < 120; ++k) {
      const auto candidates = walk.visit(k % 40);
      for (const std::int64_t id : candidates.places) text += " " + std::to_string(id);
      for (const std::int64_t id : candidates.retrieve) text += " +" + std::to_string(id);
      for (const std::int64_t id : walk.forget(0.0)) text += " -" + std::to_string(id);
    }
    return text;
  };
  const std::string once = told(nullptr);
  EXPECT_NE(once.find('+'), std::string::npos);
  EXPECT_NE(once.find('-'), std::string::npos);
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    EXPECT_EQ(told(&pool), once) << threads;
  }
}

}  // namespace
}  // namespace rastro
