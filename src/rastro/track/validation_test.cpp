// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/validation.h"

#include <gtest/gtest.h>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr std::int64_t current_frame = 4;

/// Features observed up to frame 3 and followed into frame 4, beside lost ones that a corner of frame 4 may be.
class Scene {
 public:
  TrackOptions options;

  Eigen::Vector2f random_pixel(float left = 0.0F, float width = 600.0F) {
    return {left + width * static_cast<float>(random_.uniform()), 400.0F * static_cast<float>(random_.uniform())};
  }
  void add_followed(const Eigen::Vector2f& before, const Eigen::Vector2f& now,
                    const std::vector<std::int64_t>& frames = {3}) {
    associations_.push_back({add_lost(before, frames), now, now});
  }
  void add_moving(int count, const Eigen::Vector2f& motion, float left = 0.0F, float width = 600.0F) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2f before = random_pixel(left, width);
      add_followed(before, before + motion);
    }
  }
  std::size_t add_lost(const Eigen::Vector2f& pixel, const std::vector<std::int64_t>& frames = {3}) {
    const std::size_t track = store_.create();
    for (const std::int64_t frame : frames) store_[track].observe(frame, pixel, pixel, {});
    return track;
  }
  bool confirms(std::size_t track, const Eigen::Vector2f& pixel) {
    Validation validation(store_, current_frame, associations_, options);
    const bool confirmed = validation.confirms(track, pixel);
    estimated = validation.estimated();
    return confirmed;
  }
  int estimated = 0;

 private:
  TrackStore store_{30};
  std::vector<Association> associations_;
  Random random_{3};
};

TEST(Validation, AHomographyConfirmsWithinTheReprojectionErrorAndNoFarther) {
  Scene scene;
  scene.add_moving(40, {10.0F, -4.0F});
  const std::size_t lost = scene.add_lost({200.0F, 150.0F});
  EXPECT_TRUE(scene.confirms(lost, {210.0F, 146.0F}));
  EXPECT_TRUE(scene.confirms(lost, {212.45F, 146.0F}));
  EXPECT_FALSE(scene.confirms(lost, {212.55F, 146.0F}));
  EXPECT_FALSE(scene.confirms(lost, {200.0F, 150.0F})) << "it did not stand still";
}

TEST(Validation, AMotionNeedsAsManyInliersAsTheOptionSays) {
  for (const int sharing : {7, 8}) {
    Scene scene;
    scene.add_moving(sharing, {10.0F, -4.0F});
    const std::size_t lost = scene.add_lost({200.0F, 150.0F});
    EXPECT_EQ(scene.confirms(lost, {210.0F, 146.0F}), sharing == 8) << sharing;
  }
  Scene scene;
  scene.add_moving(7, {10.0F, -4.0F});
  scene.add_followed({300.0F, 300.0F}, {220.0F, 380.0F});
  const std::size_t lost = scene.add_lost({200.0F, 150.0F});
  EXPECT_FALSE(scene.confirms(lost, {210.0F, 146.0F})) << "eight pairs, but seven inliers";
}

TEST(Validation, AHomographyOfTooFewOfTheFeaturesNeedsTheNeighborsToAgree) {
  for (const int sharing : {35, 36}) {  // of 48, where the least share is 0.75
    Scene scene;
    scene.add_moving(sharing, {10.0F, -4.0F}, 0.0F, 400.0F);
    scene.add_moving(48 - sharing, {-20.0F, 15.0F}, 500.0F, 60.0F);
    const std::size_t among_others = scene.add_lost({530.0F, 200.0F}), among_its_own = scene.add_lost({200.0F, 200.0F});
    EXPECT_EQ(scene.confirms(among_others, {540.0F, 196.0F}), sharing == 36) << sharing;
    EXPECT_TRUE(scene.confirms(among_its_own, {210.0F, 196.0F})) << sharing;
    EXPECT_FALSE(scene.confirms(among_others, {510.0F, 215.0F})) << "no neighbors outvote the homography";
  }
}

TEST(Validation, AnEpipolarLineConfirmsWhatLiesAlongIt) {
  Scene scene;
  scene.options.validation = "epipolar";
  for (int i = 0; i < 60; ++i) {  // the camera goes sideways among points of many depths
    const Eigen::Vector2f before = scene.random_pixel();
    scene.add_followed(before, before - Eigen::Vector2f(5.0F + static_cast<float>(i % 17), 0.0F));
  }
  const std::size_t lost = scene.add_lost({300.0F, 200.0F});
  EXPECT_TRUE(scene.confirms(lost, {296.0F, 200.0F}));
  EXPECT_TRUE(scene.confirms(lost, {240.0F, 200.0F})) << "whatever its depth";
  // The distance of Sampson counts the line's in both images: sqrt(1/2) of that in one.
  EXPECT_TRUE(scene.confirms(lost, {280.0F, 203.4F}));
  EXPECT_FALSE(scene.confirms(lost, {280.0F, 203.7F}));
}

TEST(Validation, NeighborsAloneConfirmWhereThatIsAskedFor) {
  Scene scene;
  scene.options.validation = "local";
  scene.add_moving(60, {10.0F, -4.0F}, 0.0F, 400.0F);
  scene.add_moving(20, {-20.0F, 15.0F}, 500.0F, 60.0F);
  const std::size_t right = scene.add_lost({530.0F, 200.0F}), left = scene.add_lost({200.0F, 200.0F});
  EXPECT_TRUE(scene.confirms(right, {510.0F, 215.0F}));
  EXPECT_FALSE(scene.confirms(right, {540.0F, 196.0F}));
  EXPECT_TRUE(scene.confirms(left, {210.0F, 196.0F}));
  EXPECT_FALSE(scene.confirms(left, {180.0F, 215.0F}));
}

TEST(Validation, AsksTheNewestFrameFirstAndOlderOnesOnlyIfItDeclines) {
  Scene scene;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector2f before = scene.random_pixel();
    scene.add_followed(before, before + Eigen::Vector2f(10.0F, -4.0F), {1, 2, 3});
  }
  const std::size_t lost = scene.add_lost({200.0F, 150.0F}, {1, 2, 3});
  EXPECT_TRUE(scene.confirms(lost, {210.0F, 146.0F}));
  EXPECT_EQ(scene.estimated, 1);
  EXPECT_FALSE(scene.confirms(lost, {250.0F, 146.0F}));
  EXPECT_EQ(scene.estimated, 3);
  const std::size_t gone_earlier = scene.add_lost({200.0F, 150.0F}, {1});
  EXPECT_TRUE(scene.confirms(gone_earlier, {210.0F, 146.0F}));
  EXPECT_EQ(scene.estimated, 1) << "only frames in which it was observed";
}

TEST(Validation, AnOlderFrameConfirmsWhereTheNewestSharesTooFew) {
  Scene scene;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector2f before = scene.random_pixel();
    scene.add_followed(before, before + Eigen::Vector2f(10.0F, -4.0F), {0});
  }
  const std::size_t lost = scene.add_lost({200.0F, 150.0F}, {0, 3});
  EXPECT_TRUE(scene.confirms(lost, {210.0F, 146.0F})) << "frame 0 counts, too";
  EXPECT_EQ(scene.estimated, 2);
}

TEST(Validation, AFrameOutsideTheWindowIsNotAsked) {
  TrackStore store(3);
  std::vector<Association> associations;
  Random random(3);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector2f pixel(600.0F * static_cast<float>(random.uniform()),
                                400.0F * static_cast<float>(random.uniform()));
    const std::size_t track = store.create();
    for (const std::int64_t frame : {6, 7}) store[track].observe(frame, pixel, pixel, {});
    associations.push_back({track, pixel, pixel});
  }
  const std::size_t lost = store.create();
  for (const std::int64_t frame : {6, 7}) store[lost].observe(frame, {90.0F, 90.0F}, {90.0F, 90.0F}, {});
  const TrackOptions options;
  Validation validation(store, 10, associations, options);
  EXPECT_FALSE(validation.confirms(lost, {200.0F, 90.0F}));
  EXPECT_EQ(validation.estimated(), 1) << "of frame 7, the oldest of the window";
  EXPECT_TRUE(validation.confirms(lost, {90.0F, 90.0F}));
  EXPECT_EQ(validation.estimated(), 1) << "each motion is estimated once";
}

}  // namespace
}  // namespace rastro
