// SPDX-License-Identifier: Apache-2.0
// Where lost features are sought, how alike they must be, and which patch decides.
#include "rastro/track/reappearance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

using PathFrom = std::function<Eigen::Vector2f(const Eigen::Vector2f& start, std::int64_t frame)>;

Eigen::Vector2f stands(const Eigen::Vector2f& start, std::int64_t) { return start; }

/// Waves; `other` of them are of another image.
GrayImage waves_with(double other) {
  GrayImage image(300, 300);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + 45.0 * std::sin(0.21 * x + 0.05 * y) +
                                                             40.0 * std::sin(0.17 * y - 0.08 * x) +
                                                             other * std::sin(0.5 * x - 0.6 * y)));
  return image;
}

Pyramid pyramid_of(const GrayImage& image) {
  Pyramid pyramid;
  pyramid.build(image.view(), 1, klt_padding, nullptr);
  return pyramid;
}

/// The first bits of an empty descriptor flipped.
Descriptor differing_in(int bits) {
  Descriptor descriptor;
  for (int bit = 0; bit < bits; ++bit)
    descriptor.words[static_cast<std::size_t>(bit / 64)] ^= std::uint64_t{1} << (bit % 64);
  return descriptor;
}

/// A feature in the middle of a scene, of which others are followed while it is lost. All look alike.
struct LostScene {
  static inline const Eigen::Vector2f middle{150.0F, 150.0F};

  std::size_t add(const Eigen::Vector2f& start, const PathFrom& motion) {
    tracks.push_back(store.create());
    starts.push_back(start);
    motions.push_back(motion);
    return tracks.back();
  }
  void add_around(int count, double nearest, double farthest, const PathFrom& motion) {
    for (int i = 0; i < count; ++i) {
      const double angle = random.uniform(0.0, 2.0 * M_PI), distance = random.uniform(nearest, farthest);
      add(middle + Eigen::Vector2d(distance * std::cos(angle), distance * std::sin(angle)).cast<float>(), motion);
    }
  }
  /// Follows all but the lost one to the frame; it is seen in its frames.
  void follow_to(std::int64_t last) {
    for (std::int64_t frame = now + 1; frame <= last; ++frame) {
      followed.clear();
      for (std::size_t i = 0; i < tracks.size(); ++i) {
        const Eigen::Vector2f pixel = motions[i](starts[i], frame);
        if (tracks[i] != lost) followed.push_back({tracks[i], pixel, pixel});
      }
      history.advance(frame, followed, store);
      for (const Association& feature : followed) store[feature.track].observe(frame, feature.pixel, feature.ideal, {});
    }
    now = last;
  }
  void see_lost(std::int64_t frame) { store[lost].observe(frame, middle, middle, {}); }
  void keep_patch(std::int64_t frame, const Pyramid& of, const Eigen::Vector2f& off = Eigen::Vector2f::Zero()) {
    store[lost].keep_patch(frame, 1, of, middle + off, options.patch_window_px);
  }
  /// Where it is asked for room.
  std::vector<Eigen::Vector2f> sought() {
    std::vector<Eigen::Vector2f> asked;
    const auto none = [&](const Eigen::Vector2f& pixel) {
      asked.push_back(pixel);
      return false;
    };
    find(none, [](const Eigen::Vector2f&, double, double) { return Descriptor(); });
    return asked;
  }
  /// With room everywhere, and descriptors that differ by so much before and after alignment.
  std::vector<Reappeared> found(int before = 0, int after = 0) {
    int asked = 0;
    return find([](const Eigen::Vector2f&) { return true; },
                [&](const Eigen::Vector2f&, double, double) { return differing_in(asked++ == 0 ? before : after); });
  }

  TrackOptions options;
  TrackStore store{30};
  MotionHistory history{options};
  std::size_t lost = store.create();
  std::int64_t now = -1;
  Pyramid image = pyramid_of(waves_with(0.0));

 private:
  std::vector<Reappeared> find(const HasRoom& has_room, const DescribeRotated& describe) {
    if (store.lost().empty()) store.mark_lost(lost);
    return find_reappeared(followed, store, now, history, UndistortedCamera(std::nullopt), image, has_room, describe,
                           options);
  }
  Random random{6};
  std::vector<std::size_t> tracks;
  std::vector<Eigen::Vector2f> starts;
  std::vector<PathFrom> motions;
  std::vector<Association> followed;
};

/// One that stands still, last seen with its patch in frame 2.
void lose_in_frame_two(LostScene& scene) {
  scene.add_around(40, 20.0, 100.0, stands);
  scene.follow_to(2);
  scene.see_lost(2);
  scene.keep_patch(2, scene.image);
}

TEST(ReappearanceSearch, AFeatureIsSoughtWhereItsLayerMovedAndThenWhereTheOtherDid) {
  for (const int layer : {-1, 0, 1}) {
    for (const float apart_px : {0.8F, 1.2F}) {
      // The other layer turns about the feature and moves it by so much.
      const PathFrom turning = [&](const Eigen::Vector2f& start, std::int64_t frame) {
        const auto t = static_cast<float>(frame);
        return Eigen::Vector2f(LostScene::middle + Eigen::Vector2f(apart_px * t / 4.0F, 0.0F) +
                               Eigen::Rotation2Df(0.1F * t) * (start - LostScene::middle));
      };
      LostScene scene;
      scene.add_around(60, 60.0, 140.0, stands);
      scene.add_around(40, 60.0, 140.0, turning);
      scene.follow_to(0);
      scene.see_lost(0);
      scene.follow_to(4);
      scene.store[scene.lost].layer = layer;
      std::vector<Eigen::Vector2f> expected{LostScene::middle, LostScene::middle + Eigen::Vector2f(apart_px, 0.0F)};
      if (layer == 1) std::swap(expected[0], expected[1]);
      if (apart_px < 1.0F) expected.pop_back();
      const std::vector<Eigen::Vector2f> sought = scene.sought();
      ASSERT_EQ(sought.size(), expected.size()) << layer << ' ' << apart_px;
      for (std::size_t i = 0; i < sought.size(); ++i) EXPECT_LT((sought[i] - expected[i]).norm(), 0.05F) << i;
    }
  }
}

TEST(ReappearanceSearch, ItLooksAlikeUpToTheLargestDistanceAndBeforeAlignmentEightBeyond) {
  LostScene scene;
  lose_in_frame_two(scene);
  scene.follow_to(5);
  const int most = scene.options.max_hamming;
  EXPECT_EQ(scene.found(most + 8, most).size(), 1U);
  EXPECT_TRUE(scene.found(most + 9, most).empty());
  EXPECT_TRUE(scene.found(most + 8, most + 1).empty());
}

TEST(ReappearanceSearch, OnlyObservationsOfTheWindowVote) {
  for (const int observed : {1, 2, 3}) {
    LostScene scene;
    scene.options.min_votes = 2;
    scene.add_around(40, 20.0, 100.0, stands);
    for (std::int64_t frame = 2; frame < 2 + observed; ++frame) {
      scene.follow_to(frame);
      scene.see_lost(frame);
      scene.keep_patch(frame, scene.image);
    }
    scene.follow_to(7);
    EXPECT_EQ(scene.found().size(), observed >= 2 ? 1U : 0U) << observed;
  }
  for (const std::int64_t now : {32, 33}) {
    LostScene scene;
    lose_in_frame_two(scene);
    scene.follow_to(now);
    EXPECT_EQ(scene.found().size(), now == 32 ? 1U : 0U) << "seen 30 frames ago, and 31";
  }
}

TEST(ReappearanceSearch, OneJustLostMustFitAsATrackedOneAndLaterLess) {
  for (const std::int64_t gone : {3, 4, 5, 6}) {
    LostScene scene;
    scene.add_around(40, 20.0, 100.0, stands);
    scene.follow_to(2);
    scene.see_lost(2);
    scene.keep_patch(2, pyramid_of(waves_with(25.0)));
    scene.follow_to(2 + gone);
    const std::vector<Reappeared> found = scene.found();
    ASSERT_EQ(found.size(), gone > scene.options.reference_interval ? 1U : 0U) << gone;
    if (found.empty()) continue;
    EXPECT_GT(found.front().residual_ratio, static_cast<float>(scene.options.max_residual_ratio));
    EXPECT_LT(found.front().residual_ratio, static_cast<float>(scene.options.max_alignment_residual));
  }
}

/// Where it is found with an older patch of 2 px beside it and a newer one of 2 px below, with so much disturbance.
Eigen::Vector2f off_with_patches(double older, double newer) {
  LostScene scene;
  scene.options.max_alignment_residual = 0.5;
  scene.add_around(40, 20.0, 100.0, stands);
  scene.follow_to(1);
  scene.see_lost(1);
  scene.keep_patch(1, pyramid_of(waves_with(older)), {2.0F, 0.0F});
  scene.follow_to(2);
  scene.see_lost(2);
  scene.keep_patch(2, pyramid_of(waves_with(newer)), {0.0F, 2.0F});
  scene.follow_to(8);
  const std::vector<Reappeared> found = scene.found();
  return found.size() == 1 ? Eigen::Vector2f(found.front().pixel - LostScene::middle) : Eigen::Vector2f(1e3F, 1e3F);
}

TEST(ReappearanceSearch, TheOlderPatchDecidesIfItFitsLikeATrackedOneElseTheBetterOfBoth) {
  const Eigen::Vector2f by_older(2.0F, 0.0F), by_newer(0.0F, 2.0F);
  EXPECT_LT((off_with_patches(10.0, 0.0) - by_older).norm(), 0.5F) << "good enough";
  EXPECT_LT((off_with_patches(25.0, 10.0) - by_newer).norm(), 0.5F) << "the newer one fits better";
  EXPECT_LT((off_with_patches(25.0, 35.0) - by_older).norm(), 0.7F) << "the newer one fits less";
  EXPECT_LT((off_with_patches(25.0, 120.0) - by_older).norm(), 0.7F) << "the newer one does not fit";
  EXPECT_LT((off_with_patches(120.0, 25.0) - by_newer).norm(), 0.7F) << "the older one does not fit";
  EXPECT_GT(off_with_patches(120.0, 120.0).norm(), 1e2F) << "neither fits";
}

/// After frame 2, of 60 features so many move each to a place of its own.
bool found_among_movers(int moving, bool moving_are_near) {
  const PathFrom moves = [](const Eigen::Vector2f& start, std::int64_t frame) {
    const Eigen::Vector2f away(std::fmod(37.0F * start.x(), 30.0F) - 15.0F,
                               std::fmod(53.0F * start.y(), 30.0F) - 15.0F);
    return frame <= 2 ? start : Eigen::Vector2f(start + away + away.normalized() * 20.0F);
  };
  LostScene scene;
  scene.add_around(moving, moving_are_near ? 20.0 : 90.0, moving_are_near ? 50.0 : 140.0, moves);
  scene.add_around(60 - moving, moving_are_near ? 90.0 : 20.0, moving_are_near ? 140.0 : 50.0, stands);
  scene.follow_to(2);
  scene.see_lost(2);
  scene.keep_patch(2, scene.image);
  scene.follow_to(3);
  return !scene.found().empty();
}

TEST(ReappearanceSearch, AMotionOfTooFewFeaturesNeedsTheNeighborsToAgree) {
  EXPECT_TRUE(found_among_movers(14, true)) << "three in four agree";
  EXPECT_FALSE(found_among_movers(17, true));
  EXPECT_TRUE(found_among_movers(17, false));
}

}  // namespace
}  // namespace rastro
