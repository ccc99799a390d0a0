// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/track_store.h"

#include <gtest/gtest.h>

#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

Pyramid wave_pyramid() {
  Pyramid pyramid;
  pyramid.build(testing::wave_image(120, 90, 0.0, 0.0).view(), 1, klt_padding);
  return pyramid;
}

Descriptor with_bits(int count) {
  Descriptor descriptor;
  for (int bit = 0; bit < count; ++bit)
    descriptor.words[static_cast<std::size_t>(bit / 64)] |= std::uint64_t{1} << (bit % 64);
  return descriptor;
}

TEST(Track, KeepsItsPatchAtIntervalsAndTheOneBefore) {
  const Pyramid pyramid = wave_pyramid();
  Track track(30);
  track.start(0);
  EXPECT_EQ(track.patch_frame(), -1);
  EXPECT_EQ(track.newest_patch_frame(), -1);
  EXPECT_TRUE(track.reference_patch().empty());
  for (std::int64_t frame = 2; frame <= 13; ++frame) {
    track.keep_patch(frame, 4, pyramid, {50.0F, 40.0F}, 21);
    const std::int64_t newest = 2 + (frame - 2) / 4 * 4;
    EXPECT_EQ(track.newest_patch_frame(), newest) << frame;
    EXPECT_EQ(track.patch_frame(), std::max<std::int64_t>(2, newest - 4)) << frame;
    EXPECT_FALSE(track.reference_patch().empty());
  }
  track.start(1);
  EXPECT_TRUE(track.reference_patch().empty());
  EXPECT_TRUE(track.newest_patch().empty());
  EXPECT_EQ(track.patch_frame(), -1);
}

TEST(Track, TheOlderPatchIsOfWhereItWasThen) {
  const Pyramid pyramid = wave_pyramid();
  Track track(30);
  track.start(0);
  track.keep_patch(0, 4, pyramid, {40.0F, 40.0F}, 21);
  track.keep_patch(4, 4, pyramid, {70.0F, 50.0F}, 21);
  EXPECT_LT(track.reference_patch().residual_ratio(pyramid, {40.0F, 40.0F}), 1e-6);
  EXPECT_GT(track.reference_patch().residual_ratio(pyramid, {70.0F, 50.0F}), 0.1);
  EXPECT_LT(track.newest_patch().residual_ratio(pyramid, {70.0F, 50.0F}), 1e-6);
}

TEST(Track, SpreadIsTheFarthestDescriptorFromTheLastOne) {
  Track track(30);
  track.start(0);
  for (const auto& [frame, bits] : {std::pair{3, 40}, {4, 3}, {7, 25}}) track.observe(frame, {}, {}, with_bits(bits));
  track.measure_spread();
  EXPECT_EQ(track.descriptor_spread, 22);
  track.observe(8, {}, {}, with_bits(41));
  track.measure_spread();
  EXPECT_EQ(track.descriptor_spread, 38);
  track.start(1);
  EXPECT_EQ(track.descriptor_spread, 0);
  track.observe(9, {}, {}, with_bits(200));
  track.measure_spread();
  EXPECT_EQ(track.descriptor_spread, 0) << "of the track before there is nothing left";
  EXPECT_EQ(track.age, 1);
  EXPECT_EQ(track.seen_before, -1);
  EXPECT_EQ(track.layer, -1);
}

TEST(TrackStore, LostTracksAreInTheOrderOfTheirIds) {
  TrackStore store(5);
  for (int i = 0; i < 5; ++i) store[store.create()].observe(0, {}, {}, {});
  for (const std::size_t index : {3U, 0U, 4U, 1U}) store.mark_lost(index);
  EXPECT_EQ(store.lost(), (std::vector<std::size_t>{0, 1, 3, 4}));
  store.mark_found(3);
  EXPECT_EQ(store.lost(), (std::vector<std::size_t>{0, 1, 4}));
  store.discard(3);
  const std::size_t again = store.create();
  EXPECT_EQ(again, 3U) << "the slot of the one that was discarded";
  EXPECT_EQ(store[again].id, 5);
  store[again].observe(1, {}, {}, {});
  store.mark_lost(again);
  EXPECT_EQ(store.lost(), (std::vector<std::size_t>{0, 1, 4, 3})) << "its id is the largest";
  EXPECT_EQ(store.size(), 5U);
}

TEST(TrackStore, ForgetsOnlyWhatLeftTheWindow) {
  TrackStore store(5);
  for (const std::int64_t last : {0, 3, 1, 2}) {
    const std::size_t index = store.create();
    store[index].observe(last, {}, {}, {});
    store.mark_lost(index);
  }
  store.forget_old(7);
  EXPECT_EQ(store.lost(), (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(store.create(), 2U);
  EXPECT_EQ(store.create(), 0U);
  EXPECT_EQ(store.create(), 4U);
}

}  // namespace
}  // namespace rastro
