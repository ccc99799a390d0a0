// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// Labbe and Michaud 2013, table I; the neighbors of a hypothesis are the only other candidates there.
TEST(RtabmapOptions, ThePaperPresetHasThePaperValues) {
  RtabmapOptions options;
  set_paper_preset(options);
  EXPECT_EQ(options.distance_ratio, 0.8);
  EXPECT_EQ(options.words_per_image, 400);
  EXPECT_EQ(options.bad_signature, 0.25);
  EXPECT_EQ(options.short_term_size, 30);
  EXPECT_EQ(options.rehearsal_similarity, 0.2);
  EXPECT_EQ(options.time_limit_ms, 700.0);
  EXPECT_EQ(options.retrieved_neighbors, 2);
  EXPECT_EQ(options.loop_probability, 0.11);
  EXPECT_EQ(options.stays_new, 0.9);
  EXPECT_EQ(options.hypotheses, 1);
  EXPECT_EQ(options.similar_locations, 0);
  EXPECT_EQ(options.rgbd.near_candidates + options.rgbd.graph_candidates + options.rgbd.last_candidates, 0);
}

TEST(RtabmapOptions, PlaceRecognitionReplacesTheSearchByChance) {
  RtabmapOptions options;
  std::vector<std::string> names;
  const OptionTable table = option_table(options);
  for (const Option& option : table.options()) names.push_back(option.name);
  for (const char* name : {"random_candidates", "join_candidates", "relocalize_random", "descriptor"})
    EXPECT_THAT(names, ::testing::Not(::testing::Contains(name)));
  EXPECT_THAT(names, ::testing::Contains("keyframe_features"));
  EXPECT_EQ(options.rgbd.random_candidates + options.rgbd.join_candidates + options.rgbd.relocalize_random, 0);
}

TEST(RtabmapOptions, AMistypedNameIsToldTheNearest) {
  RtabmapOptions options;
  OptionTable table = option_table(options);
  try {
    table.set("short_term_sice", "10", "a test");
    FAIL() << "taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("short_term_size"));
  }
  table.set("short_term_size", "10", "a test");
  EXPECT_EQ(options.short_term_size, 10);
}

}  // namespace
}  // namespace rastro
