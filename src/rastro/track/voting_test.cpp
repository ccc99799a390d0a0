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

/// METHODS 1, steps 4 and 5, word by word: every frame of the window against every feature of it.
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

/// Tracks of a few look-alike families, seen in random frames 0..frames-1 and then lost.
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

TEST(Voting, NothingLostNothingProposed) {
  TrackStore store(30);
  Voting voting(store, 5, {});
  const Descriptor descriptor;
  EXPECT_TRUE(voting.candidates_for(std::span(&descriptor, 1)).empty());
}

TEST(TrackStore, ForgetsWhatLeftTheWindowAndReusesItsPlace) {
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
