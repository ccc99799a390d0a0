// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/voting.h"

#include <gtest/gtest.h>

#include <map>

#include "rastro/base/random.h"

namespace rastro {
namespace {

Descriptor random_descriptor(Random& random) {
  Descriptor descriptor;
  for (auto& word : descriptor.words) word = random.next();
  return descriptor;
}

Descriptor with_flips(Descriptor descriptor, int flips, Random& random) {
  for (int i = 0; i < flips; ++i) {
    const auto bit = random.below(256);
    descriptor.words[bit / 64] ^= std::uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

/// METHODS 1, steps 4 and 5, literally: every frame of the window against every feature of it.
std::vector<Candidate> brute_force(const TrackStore& store, std::int64_t current, const Descriptor& corner,
                                   const VotingOptions& options) {
  std::map<std::size_t, Candidate> votes;
  for (std::int64_t frame = std::max<std::int64_t>(0, current - store.window()); frame < current; ++frame) {
    std::vector<std::tuple<int, std::int64_t, std::size_t>> alike;
    for (const std::size_t track : store.lost()) {
      if (!store[track].seen_in(frame)) continue;
      const int distance = hamming_distance(corner, store[track].descriptors()[store[track].slot(frame)]);
      if (distance <= options.max_hamming) alike.emplace_back(distance, store[track].id, track);
    }
    std::sort(alike.begin(), alike.end());
    for (std::size_t i = 0; i < std::min(alike.size(), static_cast<std::size_t>(options.proposals_per_frame)); ++i) {
      const auto [distance, id, track] = alike[i];
      Candidate& candidate = votes.try_emplace(track, Candidate{track, 0, 0}).first->second;
      ++candidate.votes;
      candidate.distance += distance;
    }
  }
  std::vector<Candidate> ranked;
  for (const auto& [track, candidate] : votes) {
    if (candidate.votes >= options.min_votes) ranked.push_back(candidate);
  }
  std::sort(ranked.begin(), ranked.end(), [&](const Candidate& a, const Candidate& b) {
    return std::tuple(-a.votes, a.distance, store[a.track].id) < std::tuple(-b.votes, b.distance, store[b.track].id);
  });
  ranked.resize(std::min(ranked.size(), static_cast<std::size_t>(options.candidates)));
  return ranked;
}

/// Tracks of a few similar families, observed in random frames 0..frames-1 and then lost.
TrackStore lost_tracks(Random& random, int window, int count, std::int64_t frames, std::vector<Descriptor>& families) {
  for (int i = 0; i < 6; ++i) families.push_back(random_descriptor(random));
  TrackStore store(window);
  for (int i = 0; i < count; ++i) {
    const std::size_t track = store.create();
    const Descriptor base = with_flips(families[random.below(6)], 25, random);
    for (std::int64_t frame = 0; frame < frames; ++frame) {
      if (random.uniform() < 0.6) store[track].observe(frame, {1.0F, 1.0F}, {1.0F, 1.0F}, with_flips(base, 12, random));
    }
    if (store[track].last_seen < 0) store[track].observe(frames - 1, {1.0F, 1.0F}, {1.0F, 1.0F}, base);
  }
  for (int i = 0; i < count; ++i) store.mark_lost(static_cast<std::size_t>(i));
  store.forget_old(frames);
  return store;
}

TEST(Voting, EqualsBruteForceOverTheWholeWindow) {
  Random random(17);
  for (int round = 0; round < 12; ++round) {
    std::vector<Descriptor> families;
    const std::int64_t frames = 14;
    const TrackStore store = lost_tracks(random, 10, 40, frames, families);
    for (const VotingOptions& options :
         {VotingOptions{50, 1, 1, 1}, {50, 1, 2, 1}, {50, 2, 2, 1}, {35, 2, 2, 3}, {256, 2, 2, 1}}) {
      Voting voting(store, frames, options);
      for (int corner = 0; corner < 10; ++corner) {
        const Descriptor descriptor = with_flips(families[random.below(6)], 20, random);
        const auto expected = brute_force(store, frames, descriptor, options);
        const auto found = voting.candidates_for(std::span(&descriptor, 1));
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
          EXPECT_EQ(found[i].track, expected[i].track);
          EXPECT_EQ(found[i].votes, expected[i].votes);
          EXPECT_EQ(found[i].distance, expected[i].distance);
        }
      }
    }
  }
}

TEST(Voting, ProposesNothingWithoutLostTracks) {
  TrackStore store(30);
  Voting voting(store, 5, {});
  const Descriptor descriptor;
  EXPECT_TRUE(voting.candidates_for(std::span(&descriptor, 1)).empty());
}

/// Two lost tracks of one descriptor, 300 pixels apart.
struct TwoLost {
  TrackStore store{30};
  Descriptor descriptor;
  TwoLost() {
    Random random(3);
    descriptor = random_descriptor(random);
    for (const Eigen::Vector2f& pixel : {Eigen::Vector2f(100.0F, 200.0F), Eigen::Vector2f(400.0F, 200.0F)}) {
      const std::size_t track = store.create();
      store[track].observe(3, pixel, pixel, descriptor);
      store.mark_lost(track);
    }
  }
  /// The tracks proposed for a corner; -1: select_near() says that there are none.
  std::vector<std::int64_t> proposed(const Eigen::Vector2f& corner, double max_travel_px,
                                     const std::vector<std::optional<Eigen::Vector2f>>& motions) const {
    Voting voting(store, 5, {50, 2, 2, 1, max_travel_px});
    voting.expect(motions);
    if (!voting.select_near(corner)) return {-1};
    std::vector<std::int64_t> ids;
    for (const Candidate& candidate : voting.candidates_for(std::span(&descriptor, 1)))
      ids.push_back(store[candidate.track].id);
    return ids;
  }
};

using Ids = std::vector<std::int64_t>;

TEST(Voting, ComparesOnlyWhatMayHaveTraveledToTheCorner) {
  const TwoLost lost;
  const Eigen::Vector2f still(0.0F, 0.0F);
  EXPECT_EQ(lost.proposed({160.0F, 200.0F}, 60.0, {still, still}), Ids{0}) << "at exactly the largest distance";
  EXPECT_EQ(lost.proposed({160.5F, 200.0F}, 60.0, {still, still}), Ids{-1});
  EXPECT_EQ(lost.proposed({100.0F, 260.5F}, 60.0, {still, still}), Ids{-1});
  EXPECT_EQ(lost.proposed({400.0F, 141.0F}, 60.0, {still, still}), Ids{1});
  EXPECT_EQ(lost.proposed({250.0F, 200.0F}, 150.0, {still, still}), (Ids{0, 1}));
}

TEST(Voting, TravelCountsFromTheOldPositionOrFromWhereTheOthersMoved) {
  const TwoLost lost;
  const Eigen::Vector2f moved(0.0F, 150.0F);
  EXPECT_EQ(lost.proposed({100.0F, 350.0F}, 60.0, {moved, moved}), Ids{0});
  EXPECT_EQ(lost.proposed({100.0F, 409.0F}, 60.0, {moved, moved}), Ids{0});
  EXPECT_EQ(lost.proposed({100.0F, 200.0F}, 60.0, {moved, moved}), Ids{0}) << "it may as well have stood still";
  EXPECT_EQ(lost.proposed({100.0F, 275.0F}, 60.0, {moved, moved}), Ids{-1}) << "between both";
  EXPECT_EQ(lost.proposed({100.0F, 50.0F}, 60.0, {moved, moved}), Ids{-1}) << "against the motion";
}

TEST(Voting, WithoutALimitOrAMotionEverythingIsCompared) {
  const TwoLost lost;
  const Eigen::Vector2f still(0.0F, 0.0F);
  EXPECT_EQ(lost.proposed({250.0F, 900.0F}, 0.0, {still, still}), (Ids{0, 1}));
  EXPECT_EQ(lost.proposed({250.0F, 900.0F}, 60.0, {std::nullopt, still}), Ids{0}) << "nobody knows how far it went";
  EXPECT_EQ(lost.proposed({400.0F, 200.0F}, 60.0, {std::nullopt, still}), (Ids{0, 1}));
  const TrackStore none(30);
  Voting voting(none, 5, {50, 2, 2, 1, 60.0});
  voting.expect({});
  EXPECT_FALSE(voting.select_near({1.0F, 1.0F}));
}

TEST(Voting, EachObservationTakesTheNearestOfSeveralViews) {
  Random random(8);
  const TwoLost lost;
  const Descriptor far = random_descriptor(random), near = with_flips(lost.descriptor, 20, random);
  Voting voting(lost.store, 5, {50, 2, 2, 1, 0.0});
  EXPECT_TRUE(voting.candidates_for(std::span(&far, 1)).empty());
  const Descriptor views[] = {far, near, far};
  const auto found = voting.candidates_for(views);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].distance, hamming_distance(near, lost.descriptor));
}

TEST(TrackStore, RemovesWhatLeftTheWindowAndReusesItsSlot) {
  TrackStore store(5);
  const std::size_t first = store.create();
  store[first].observe(0, {0, 0}, {0, 0}, {});
  store.mark_lost(first);
  store.forget_old(5);
  EXPECT_EQ(store.lost().size(), 1U);
  store.forget_old(6);
  EXPECT_TRUE(store.lost().empty());
  const std::size_t second = store.create();
  EXPECT_EQ(second, first);
  EXPECT_EQ(store[second].id, 1);
  EXPECT_FALSE(store[second].seen_in(0));
}

TEST(Track, KeepsTheWindowBesideTheCurrentFrame) {
  Track track(3);
  track.start(9);
  for (std::int64_t frame = 0; frame <= 5; ++frame) track.observe(frame, {static_cast<float>(frame), 0.0F}, {}, {});
  EXPECT_TRUE(track.seen_in(2));
  EXPECT_FALSE(track.seen_in(1));
  EXPECT_EQ(track.pixel_in(2).x(), 2.0F);
  EXPECT_EQ(track.age, 6);
  EXPECT_EQ(track.seen_before, 4);
}

}  // namespace
}  // namespace rastro
