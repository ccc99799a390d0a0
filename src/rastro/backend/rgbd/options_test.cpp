// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/options.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "rastro/base/error.h"

namespace rastro {
namespace {

TEST(RgbdSlamOptions, EveryRowSetsAMemberOfItsOwn) {
  RgbdSlamOptions options;
  OptionTable table = option_table(options);
  std::set<std::string> names;
  std::set<const void*> targets;
  for (const Option& option : table.options()) {
    EXPECT_TRUE(names.insert(option.name).second) << option.name;
    const void* target = std::visit([](auto* member) { return static_cast<const void*>(member); }, option.target);
    EXPECT_TRUE(targets.insert(target).second) << option.name << " writes where another option does";
    const auto* bytes = static_cast<const char*>(target);
    EXPECT_TRUE(bytes >= reinterpret_cast<const char*>(&options) && bytes < reinterpret_cast<const char*>(&options + 1))
        << option.name << " is of another struct";
    EXPECT_FALSE(option.why.empty()) << option.name;
  }
  EXPECT_GT(names.count("pixel_sigma"), 0U) << "the follower's are part of it";
  EXPECT_GT(names.count("keyframe_pixel_sigma"), 0U);
}

TEST(RgbdSlamOptions, BothEndsOfEveryRangeAreAllowedAndNothingBeyond) {
  RgbdSlamOptions options;
  OptionTable table = option_table(options);
  const auto text = [](const Option& option, double value) {
    return std::holds_alternative<double*>(option.target) ? std::to_string(value)
                                                          : std::to_string(static_cast<long long>(value));
  };
  int ranges = 0;
  for (const Option& option : table.options()) {
    if (option.minimum == option.maximum || std::holds_alternative<bool*>(option.target)) continue;
    ++ranges;
    for (const double end : {option.minimum, option.maximum})
      EXPECT_NO_THROW(table.set(option.name, text(option, end), "test")) << option.name << ' ' << end;
    if (option.maximum + 1.0 <= option.maximum) continue;  // seeds use all bits
    EXPECT_THROW(table.set(option.name, text(option, option.maximum + 1.0), "test"), Error) << option.name;
    EXPECT_THROW(table.set(option.name, text(option, option.minimum - 1.0), "test"), Error) << option.name;
    EXPECT_THROW(table.set(option.name, "many", "test"), Error) << option.name;
  }
  EXPECT_GT(ranges, 40);
}

TEST(RgbdSlamOptions, ChoicesAreThoseOfTheMethod) {
  RgbdSlamOptions options;
  OptionTable table = option_table(options);
  for (const char* assignment : {"descriptor=orb", "descriptor=sift", "few_features=icp", "few_features=refuse",
                                 "loops=switchable", "loops=robust", "surfaces=off"}) {
    EXPECT_NO_THROW(table.set_assignment(assignment, "test")) << assignment;
  }
  for (const char* assignment : {"descriptor=brisk", "few_features=", "loops=trusted", "loop=robust"})
    EXPECT_THROW(table.set_assignment(assignment, "test"), Error) << assignment;
  EXPECT_EQ(options.descriptor, "sift");
  EXPECT_EQ(options.follow.surfaces, "off");
}

TEST(RgbdSlamOptions, WhatIsWrittenIsReadBack) {
  RgbdSlamOptions written, read;
  OptionTable from = option_table(written), to = option_table(read);
  for (const char* assignment :
       {"near_distance_m=2.25", "loop_steps=31", "loops=robust", "seed=77", "edge_sigma_rad=0"})
    from.set_assignment(assignment, "test");
  to.load_yaml_text(from.to_yaml(), "test");
  EXPECT_EQ(to.to_yaml(), from.to_yaml());
  EXPECT_EQ(read.near_distance_m, 2.25);
  EXPECT_EQ(read.loop_steps, 31);
  EXPECT_EQ(read.loops, "robust");
  EXPECT_EQ(read.follow.seed, 77U);
  EXPECT_EQ(read.edge_sigma_rad, 0.0);
}

}  // namespace
}  // namespace rastro
