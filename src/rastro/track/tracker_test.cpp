// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "rastro/base/simd_testing.h"
#include "rastro/image/image_testing.h"
#include "rastro/synthetic/worlds/hall.h"

namespace rastro {
namespace {

constexpr int hall_frames = 32;

/// The first frames of a half-sized hall, rendered once for all tests here.
const std::vector<GrayImage>& hall() {
  static const std::vector<GrayImage> frames = [] {
    HallOptions options;
    options.scale = 0.5;
    const World world = make_hall(options);
    TaskPool pool(2);
    std::vector<GrayImage> rendered;
    rendered.reserve(hall_frames);
    for (int i = 0; i < hall_frames; ++i) rendered.push_back(world.render(i, pool).gray);
    return rendered;
  }();
  return frames;
}

/// Settings for half-sized images.
TrackOptions half_size() {
  TrackOptions options;
  options.min_distance_px = 15;
  options.brief_patch_px = 32;
  options.brief_smoothing_px = 5;
  return options;
}

std::vector<TrackFrame> run(const TrackOptions& options, const std::vector<GrayImage>& images,
                            TaskPool* pool = nullptr) {
  Tracker tracker(options, std::nullopt, pool);
  std::vector<TrackFrame> frames;
  for (std::size_t i = 0; i < images.size(); ++i)
    frames.push_back(tracker.process(images[i].view(), static_cast<TimeNs>(i)));
  return frames;
}

bool equal(const std::vector<TrackFrame>& a, const std::vector<TrackFrame>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].features.size() != b[i].features.size()) return false;
    for (std::size_t k = 0; k < a[i].features.size(); ++k) {
      const TrackedFeature &f = a[i].features[k], &g = b[i].features[k];
      if (f.id != g.id || f.pixel != g.pixel || f.state != g.state || f.age != g.age || f.last_seen != g.last_seen)
        return false;
    }
  }
  return true;
}

int reidentified(const std::vector<TrackFrame>& frames) {
  int sum = 0;
  for (const TrackFrame& frame : frames) sum += frame.reidentified;
  return sum;
}

TEST(Tracker, FrameCountsAddUp) {
  std::set<std::int64_t> known;
  for (const TrackFrame& frame : run(half_size(), hall())) {
    EXPECT_EQ(frame.tracked + frame.fresh + frame.reidentified, static_cast<int>(frame.features.size()));
    EXPECT_LE(frame.features.size(), 150U);
    std::int64_t before = -1;
    for (const TrackedFeature& feature : frame.features) {
      EXPECT_GT(feature.id, before);
      before = feature.id;
      EXPECT_EQ(known.contains(feature.id), feature.state != TrackState::fresh);
      if (feature.state == TrackState::tracked) {
        EXPECT_EQ(feature.last_seen, frame.index - 1);
      }
      if (feature.state == TrackState::reidentified) {
        // Features lost in the step to this very frame may be found in it: every id not tracked now competes.
        EXPECT_LT(feature.last_seen, frame.index);
        EXPECT_GE(feature.last_seen, frame.index - 30);
      }
      if (feature.state == TrackState::fresh) {
        EXPECT_EQ(feature.last_seen, -1);
      }
      EXPECT_TRUE(std::isnan(feature.ray.x()));
    }
    for (const TrackedFeature& feature : frame.features) known.insert(feature.id);
  }
}

TEST(Tracker, OnlyKltModeDoesNotReidentify) {
  TrackOptions options = half_size();
  options.mode = "klt";
  EXPECT_EQ(reidentified(run(options, hall())), 0);
  for (const char* mode : {"vote", "dual", "priority"}) {
    options.mode = mode;
    EXPECT_GT(reidentified(run(options, hall())), 20) << mode;
  }
}

TEST(Tracker, SameBytesOnRerunWithAnyPoolAndInPlainCode) {
  const auto frames = run(half_size(), hall());
  EXPECT_TRUE(equal(frames, run(half_size(), hall())));
  for (const int threads : {2, 8}) {
    TaskPool pool(threads);
    EXPECT_TRUE(equal(frames, run(half_size(), hall(), &pool))) << threads;
  }
  EXPECT_TRUE(testing::with_plain_code([&] { return equal(frames, run(half_size(), hall())); }));
}

TEST(Tracker, EveryValidationAndDescriptorRuns) {
  for (const char* validation : {"homography", "epipolar", "local"}) {
    for (const char* descriptor : {"upright", "steered", "scaled", "steered_scaled"}) {
      TrackOptions options = half_size();
      options.validation = validation;
      options.descriptor = descriptor;
      EXPECT_GT(reidentified(run(options, hall())), 10) << validation << ' ' << descriptor;
    }
  }
}

TEST(Tracker, MaskKeepsFeaturesOut) {
  GrayImage mask(376, 240);
  for (int y = 0; y < 240; ++y) std::memset(mask.row(y), y < 120 ? 0 : 255, 376);
  Tracker tracker(half_size());
  for (int i = 0; i < 5; ++i) {
    const TrackFrame frame = tracker.process(hall()[static_cast<std::size_t>(i)].view(), i, mask.view());
    EXPECT_GT(frame.features.size(), 10U);
    for (const TrackedFeature& feature : frame.features) EXPECT_GE(feature.pixel.y(), 119.5F);
  }
}

TEST(Tracker, RaysAreThoseOfTheCamera) {
  const Camera camera = camera_from_field_of_view(80.0, 376, 240);
  Tracker tracker(half_size(), camera);
  for (const TrackedFeature& feature : tracker.process(hall()[0].view(), 0).features) {
    const auto pixel = camera.project({feature.ray.x(), feature.ray.y(), 1.0});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR((*pixel - feature.pixel.cast<double>()).norm(), 0.0, 1e-3);
  }
}

TEST(Tracker, BlackFrameIsReportedAndTheRunContinues) {
  Tracker tracker(half_size());
  tracker.process(hall()[0].view(), 0);
  const GrayImage black(376, 240);
  const TrackFrame dark = tracker.process(black.view(), 1);
  EXPECT_EQ(dark.features.size(), 0U);
  EXPECT_EQ(dark.health, TrackHealth::dark_or_blank);
  const TrackFrame after = tracker.process(hall()[1].view(), 2);
  EXPECT_GT(after.reidentified, 50);
}

TEST(Tracker, WhatMovesUnderTheMaskIsCountedAndLost) {
  Tracker tracker(half_size());
  const TrackFrame first = tracker.process(hall()[0].view(), 0);
  GrayImage mask(376, 240);
  for (int y = 0; y < 240; ++y) std::memset(mask.row(y), y < 120 ? 0 : 255, 376);
  const auto under = std::count_if(first.features.begin(), first.features.end(),
                                   [](const TrackedFeature& feature) { return std::lround(feature.pixel.y()) < 120; });
  EXPECT_GT(under, 10);
  const TrackFrame second = tracker.process(hall()[0].view(), 1, mask.view());
  EXPECT_EQ(second.masked, under) << "the very same image: all others are followed";
  EXPECT_EQ(second.lost, under);
  EXPECT_EQ(second.tracked, static_cast<int>(first.features.size()) - under);
  const TrackFrame third = tracker.process(hall()[0].view(), 2);
  EXPECT_EQ(third.masked, 0);
  EXPECT_GT(third.reidentified, under / 4) << "as far as no new ones took their room";
}

TEST(Tracker, CornersKeepTheirDistanceFromEachOtherAndFromTheBorder) {
  for (const int border : {5, 40}) {
    TrackOptions options = half_size();
    options.corner_border_px = border;
    const std::vector<TrackedFeature> features = Tracker(options).process(hall()[0].view(), 0).features;
    EXPECT_GT(features.size(), 20U);
    for (std::size_t i = 0; i < features.size(); ++i) {
      const Eigen::Vector2f& pixel = features[i].pixel;
      EXPECT_GE(std::min(pixel.x(), pixel.y()), static_cast<float>(border) - 0.5F);
      EXPECT_LE(pixel.x(), 375.5F - static_cast<float>(border));
      EXPECT_LE(pixel.y(), 239.5F - static_cast<float>(border));
      for (std::size_t k = 0; k < i; ++k)
        EXPECT_GE((pixel - features[k].pixel).norm(), static_cast<float>(options.min_distance_px) - 1e-3F);
    }
  }
}

TEST(Tracker, NeverHasMoreFeaturesThanAskedForAndFillsUpWhatIsLost) {
  TrackOptions options = half_size();
  options.features = 40;
  for (const char* mode : {"klt", "priority"}) {
    options.mode = mode;
    for (const TrackFrame& frame : run(options, hall())) {
      EXPECT_LE(frame.features.size(), 40U) << mode;
      EXPECT_GE(frame.features.size(), frame.index == 0 ? 40U : 30U) << mode << frame.index;
    }
  }
}

TEST(Tracker, FewerThanHalfOfWhatIsAskedForAreFewCorners) {
  GrayImage mask(376, 240);
  for (int y = 60; y < 120; ++y) std::memset(mask.row(y) + 100, 255, 120);
  TrackOptions options = half_size();
  const auto health = [&](int features) {
    options.features = features;
    return Tracker(options).process(hall()[0].view(), 0, mask.view());
  };
  const int found = static_cast<int>(health(150).features.size());
  ASSERT_GT(found, 3);
  EXPECT_EQ(health(2 * found).health, TrackHealth::good);
  EXPECT_EQ(health(2 * found + 1).health, TrackHealth::few_corners);
}

TEST(Tracker, AnotherSceneIsAnAbruptMotion) {
  Tracker tracker(half_size());
  EXPECT_EQ(tracker.process(hall()[0].view(), 0).health, TrackHealth::good);
  const TrackFrame strange = tracker.process(testing::noise_image(376, 240, 4).view(), 1);
  EXPECT_EQ(strange.health, TrackHealth::abrupt_motion);
  EXPECT_LT(4 * strange.tracked, strange.tracked + strange.lost);
  EXPECT_NE(tracker.process(testing::noise_image(376, 240, 4).view(), 2).health, TrackHealth::abrupt_motion);
}

TEST(Tracker, AgeCountsTheFramesInWhichAnIdWasObserved) {
  std::map<std::int64_t, int> observed;
  std::map<std::int64_t, std::int64_t> last;
  for (const TrackFrame& frame : run(half_size(), hall())) {
    EXPECT_EQ(frame.stamp, frame.index);
    int by_state[3] = {};
    for (const TrackedFeature& feature : frame.features) {
      EXPECT_EQ(feature.age, ++observed[feature.id]);
      EXPECT_EQ(feature.last_seen, last.contains(feature.id) ? last[feature.id] : -1);
      last[feature.id] = frame.index;
      ++by_state[static_cast<int>(feature.state)];
    }
    EXPECT_EQ(by_state[static_cast<int>(TrackState::tracked)], frame.tracked);
    EXPECT_EQ(by_state[static_cast<int>(TrackState::fresh)], frame.fresh);
    EXPECT_EQ(by_state[static_cast<int>(TrackState::reidentified)], frame.reidentified);
  }
}

TEST(Tracker, WhatWasHiddenLongerThanTheWindowGetsAnotherId) {
  const GrayImage black(376, 240);
  for (const int hidden : {4, 5}) {
    TrackOptions options = half_size();
    options.window = 5;
    Tracker tracker(options);
    tracker.process(hall()[0].view(), 0);
    for (int i = 0; i < hidden; ++i) tracker.process(black.view(), i + 1);
    const TrackFrame after = tracker.process(hall()[0].view(), 10);
    EXPECT_EQ(after.reidentified > 50, hidden == 4) << hidden << ' ' << after.reidentified;
    if (hidden == 5) {
      EXPECT_EQ(after.reidentified, 0);
    }
  }
}

TEST(Tracker, EveryStateAndHealthHasAName) {
  EXPECT_STREQ(name_of(TrackState::tracked), "tracked");
  EXPECT_STREQ(name_of(TrackState::fresh), "new");
  EXPECT_STREQ(name_of(TrackState::reidentified), "reidentified");
  EXPECT_STREQ(name_of(TrackHealth::good), "good");
  EXPECT_STREQ(name_of(TrackHealth::few_corners), "few corners");
  EXPECT_STREQ(name_of(TrackHealth::dark_or_blank), "dark or blank");
  EXPECT_STREQ(name_of(TrackHealth::abrupt_motion), "abrupt motion");
}

TEST(Tracker, BadInputIsAnErrorOfOneLine) {
  const auto line_of = [](auto&& work) {
    try {
      work();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  TrackOptions options;
  options.window = 0;
  EXPECT_NE(line_of([&] { Tracker tracker(options); }).find("window"), std::string::npos);
  options = {};
  options.features = 0;
  EXPECT_NE(line_of([&] { Tracker tracker(options); }).find("features"), std::string::npos);
  options = {};
  options.mode = "klp";
  EXPECT_NE(line_of([&] { Tracker tracker(options); }).find("klt"), std::string::npos);
  options = {};
  options.flow_window_px = 20;
  EXPECT_NE(line_of([&] { Tracker tracker(options); }).find("odd"), std::string::npos);

  Tracker tracker{TrackOptions{}};
  EXPECT_NE(line_of([&] { tracker.process({}, 0); }).find("empty"), std::string::npos);
  tracker.process(hall()[0].view(), 0);
  EXPECT_NE(line_of([&] { tracker.process(GrayImage(10, 10).view(), 1); }).find("size"), std::string::npos);
  EXPECT_NE(line_of([&] { tracker.process(hall()[1].view(), 1, GrayImage(10, 10).view()); }).find("mask"),
            std::string::npos);
  // The tracker continues after a refused frame.
  EXPECT_GT(tracker.process(hall()[1].view(), 1).tracked, 50);
}

TEST(Tracker, TinyImagesAreNoError) {
  for (const int size : {1, 2, 7, 16, 33}) {
    Tracker tracker{TrackOptions{}};
    const GrayImage image = testing::noise_image(size, size, 3);
    for (int i = 0; i < 3; ++i) EXPECT_LE(tracker.process(image.view(), i).features.size(), 150U);
  }
}

}  // namespace
}  // namespace rastro
