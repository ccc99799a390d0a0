// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/feature_count.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

OrbSlamOptions thousand_features() {
  OrbSlamOptions options;
  options.features = 1000;
  options.more_features = 1.5;
  options.few_tracked = 200;
  options.enough_tracked = 400;
  return options;
}

TEST(FeatureCount, RisesWhereFewLandmarksAreTrackedAndFallsWhereEnoughAre) {
  FeatureCount count(thousand_features(), true);
  EXPECT_EQ(count.next(), 1000);
  count.on_tracked(200);
  EXPECT_EQ(count.next(), 1000);
  count.on_tracked(199);
  EXPECT_EQ(count.next(), 1500);
  count.on_tracked(399);
  EXPECT_EQ(count.next(), 1500);
  count.on_tracked(400);
  EXPECT_EQ(count.next(), 1000);
}

TEST(FeatureCount, StaysWithDepthWhereAKeyframeBringsItsLandmarksAtOnce) {
  FeatureCount count(thousand_features(), false);
  count.on_tracked(50);
  EXPECT_EQ(count.next(), 1000);
}

TEST(FeatureCount, ALostCameraIsSearchedWithTheFeaturesOfTheMap) {
  FeatureCount count(thousand_features(), true);
  count.on_tracked(50);
  count.on_lost();
  EXPECT_EQ(count.next(), 1000);
}

TEST(FeatureCount, OneIsNeverMore) {
  OrbSlamOptions options = thousand_features();
  options.more_features = 1.0;
  FeatureCount count(options, true);
  count.on_tracked(50);
  EXPECT_EQ(count.next(), 1000);
}

}  // namespace
}  // namespace rastro
