// SPDX-License-Identifier: Apache-2.0
// How many features a motion needs, for how long it is kept, and to which motion a feature belongs.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/multiview/homography.h"
#include "rastro/track/motion_history.h"

namespace rastro {
namespace {

/// Where a feature is in a frame; nullopt: it is not followed any more.
using Path = std::function<std::optional<Eigen::Vector2f>(std::int64_t frame)>;

struct FollowedScene {
  std::size_t add(const Path& path) {
    tracks.push_back(store.create());
    paths.push_back(path);
    return tracks.back();
  }
  /// So many within a square about (300, 200), that move by a function of the frame.
  std::vector<std::size_t> add(int count, const std::function<std::optional<Eigen::Vector2f>(std::int64_t)>& moved) {
    std::vector<std::size_t> added;
    for (int i = 0; i < count; ++i) {
      const auto x = static_cast<float>(random.uniform(150.0, 450.0)),
                 y = static_cast<float>(random.uniform(50.0, 350.0));
      added.push_back(add([=](std::int64_t frame) -> std::optional<Eigen::Vector2f> {
        const auto by = moved(frame);
        return by ? std::optional(Eigen::Vector2f(Eigen::Vector2f(x, y) + *by)) : std::nullopt;
      }));
    }
    return added;
  }
  void follow_to(std::int64_t last) {
    for (std::int64_t frame = now + 1; frame <= last; ++frame) {
      followed.clear();
      for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (const auto pixel = paths[i](frame)) followed.push_back({tracks[i], *pixel, *pixel});
      }
      history.advance(frame, followed, store);
      for (const Association& feature : followed) store[feature.track].observe(frame, feature.pixel, feature.ideal, {});
    }
    now = last;
  }
  const MotionHistory::Motion* since(std::int64_t frame, int layer) {
    return history.since(frame, layer, followed, store);
  }
  /// How far the middle moved since the frame.
  std::optional<Eigen::Vector2d> moved_since(std::int64_t frame, int layer) {
    const Eigen::Vector2d middle(300.0, 200.0);
    const auto* motion = since(frame, layer);
    return motion ? std::optional(Eigen::Vector2d(*transfer(motion->current_from_frame, middle) - middle))
                  : std::nullopt;
  }

  TrackOptions options;
  TrackStore store{30};
  MotionHistory history{options};
  std::int64_t now = -1;

 private:
  Random random{4};
  std::vector<std::size_t> tracks;
  std::vector<Path> paths;
  std::vector<Association> followed;
};

Eigen::Vector2f to_the_right(double pixels) { return {static_cast<float>(pixels), 0.0F}; }
Eigen::Vector2f stays(std::int64_t) { return Eigen::Vector2f::Zero(); }

TEST(MotionHistory, MotionsAreKeptForTheWindowAndTwoIntervals) {
  FollowedScene features;
  features.add(20, stays);
  features.follow_to(60);
  const int kept = features.options.window + 2 * features.options.reference_interval + 1;
  for (const int layer : {0, 1}) {
    EXPECT_TRUE(features.since(60, layer));
    EXPECT_TRUE(features.since(60 - kept, layer));
    EXPECT_FALSE(features.since(60 - kept - 1, layer));
    EXPECT_FALSE(features.since(-1, layer));
  }
}

TEST(MotionHistory, AMotionNeedsAsManyFeaturesAsTheOptionSays) {
  for (const int count : {7, 8}) {
    FollowedScene alone;
    alone.add(count, [](std::int64_t frame) { return to_the_right(4.0 * static_cast<double>(frame)); });
    alone.follow_to(3);
    EXPECT_EQ(alone.since(1, 0) != nullptr, count >= alone.options.min_inliers);
    FollowedScene beside;
    beside.add(30, stays);
    beside.add(count, [](std::int64_t frame) { return to_the_right(9.0 * static_cast<double>(frame)); });
    beside.follow_to(3);
    const auto moved = beside.moved_since(1, 1);
    ASSERT_TRUE(moved);
    EXPECT_NEAR(moved->x(), count >= beside.options.min_inliers ? 18.0 : 0.0, 0.05) << "as the other layer";
    EXPECT_NEAR(beside.moved_since(1, 0)->x(), 0.0, 0.05);
  }
}

/// Beside a scene that stands still, an object moves by 9 px in each frame up to frame 3, then by 4 px, with so many of
/// its features.
double moved_with(int left) {
  FollowedScene features;
  features.add(40, stays);
  const auto object = [](std::int64_t frame) {
    return to_the_right(frame <= 3 ? 9.0 * static_cast<double>(frame) : 27.0 + 4.0 * static_cast<double>(frame - 3));
  };
  features.add(left, object);
  features.add(15, [&](std::int64_t frame) { return frame <= 3 ? std::optional(object(frame)) : std::nullopt; });
  features.follow_to(4);
  return features.moved_since(3, 1)->x();
}

TEST(MotionHistory, ThreeFeaturesOfALayerTellItsMotionAndTwoDoNot) {
  EXPECT_NEAR(moved_with(3), 4.0, 0.1);
  EXPECT_NEAR(moved_with(2), 9.0, 0.1) << "as before";
}

TEST(MotionHistory, TheMotionOfFewIsTheirMedian) {
  FollowedScene features;
  features.add(40, stays);
  features.add(15, [](std::int64_t frame) {
    return frame <= 3 ? std::optional(to_the_right(9.0 * static_cast<double>(frame))) : std::nullopt;
  });
  for (const float last : {20.0F, 5.0F, 6.0F}) {
    features.add(1, [last](std::int64_t frame) {
      return frame <= 3 ? to_the_right(9.0 * static_cast<double>(frame)) : Eigen::Vector2f(27.0F + last, 2.0F * last);
    });
  }
  features.follow_to(4);
  EXPECT_LT((*features.moved_since(3, 1) - Eigen::Vector2d(6.0, 12.0)).norm(), 0.1);
}

TEST(MotionHistory, WhereTheOtherLayerJoinsTheFirstBothMoveAlike) {
  FollowedScene features;
  features.add(40, stays);
  features.add(
      15, [](std::int64_t frame) { return to_the_right(9.0 * static_cast<double>(std::min<std::int64_t>(frame, 3))); });
  features.follow_to(3);
  EXPECT_NEAR(features.moved_since(2, 1)->x(), 9.0, 0.05);
  features.follow_to(4);
  EXPECT_NEAR(features.moved_since(3, 0)->x(), 0.0, 0.05);
  EXPECT_NEAR(features.moved_since(3, 1)->x(), 0.0, 0.05);
}

TEST(MotionHistory, AFeatureThatFitsBothMotionsBelongsToNeither) {
  FollowedScene features;
  // The object turns about the middle of the scene; what is near the middle hardly moves.
  const auto still_at = [&](float x, float y) {
    return features.add([=](std::int64_t) { return std::optional(Eigen::Vector2f(300.0F + x, 200.0F + y)); });
  };
  std::vector<std::size_t> of_scene, of_object, of_both;
  for (int i = 0; i < 40; ++i) {
    const float angle = 0.37F * static_cast<float>(i), far = 60.0F + 2.0F * static_cast<float>(i);
    of_scene.push_back(still_at(far * std::cos(angle), far * std::sin(angle)));
    if (i % 2 == 0) continue;
    of_object.push_back(features.add([=](std::int64_t frame) {
      const float turned = angle + 1.0F + 0.1F * static_cast<float>(frame);
      return std::optional(Eigen::Vector2f(300.0F + far * std::cos(turned), 200.0F + far * std::sin(turned)));
    }));
  }
  for (const float off : {-8.0F, 0.0F, 8.0F}) of_both.push_back(still_at(off, -off));
  features.follow_to(3);
  for (const std::size_t track : of_scene) EXPECT_EQ(features.store[track].layer, 0);
  for (const std::size_t track : of_object) EXPECT_EQ(features.store[track].layer, 1);
  for (const std::size_t track : of_both) EXPECT_EQ(features.store[track].layer, -1);
}

TEST(MotionHistory, TheInlierShareIsThatOfTheFeaturesSeenInBothFrames) {
  FollowedScene features;
  features.add(30, stays);
  for (int i = 0; i < 10; ++i) {
    features.add(1, [i](std::int64_t frame) {
      const auto by = static_cast<float>(frame > 2 ? 20 + 7 * i : 0);
      return Eigen::Vector2f(by * std::cos(2.0F * static_cast<float>(i)), by * std::sin(2.0F * static_cast<float>(i)));
    });
  }
  features.add(20, [](std::int64_t frame) { return frame > 1 ? std::optional(to_the_right(0.0)) : std::nullopt; });
  features.follow_to(3);
  for (const auto& [frame, share, seen] : {std::tuple{1, 30.0 / 40.0, 40U}, {2, 50.0 / 60.0, 60U}}) {
    const auto* motion = features.since(frame, 0);
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->shared.size(), seen);
    EXPECT_NEAR(motion->inlier_share, share, 1e-12);
  }
}

TEST(MotionHistory, AMotionIsRefinedOnceAFrame) {
  FollowedScene features;
  features.add(30, stays);
  features.follow_to(3);
  ASSERT_TRUE(features.since(1, 0));
  const auto* again = features.history.since(1, 0, {}, features.store);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->shared.size(), 30U) << "not from what it is asked with the second time";
}

TEST(DerivativeAt, StretchesToTwiceOrHalfAtMostInAnyDirection) {
  const auto plausible = [](double larger, double smaller) {
    const Eigen::Matrix2d stretched = Eigen::Rotation2Dd(0.7) * Eigen::DiagonalMatrix<double, 2>(larger, smaller) *
                                      Eigen::Rotation2Dd(-1.9).toRotationMatrix();
    Eigen::Matrix3d homography = Eigen::Matrix3d::Identity();
    homography.topLeftCorner<2, 2>() = stretched;
    const auto derivative = derivative_at(3.0 * homography, {20.0F, -30.0F});
    EXPECT_TRUE(!derivative || (derivative->cast<double>() - stretched).norm() < 1e-5);
    return derivative.has_value();
  };
  for (const double other : {0.6, 1.0, 1.8}) {
    EXPECT_TRUE(plausible(1.99, other));
    EXPECT_FALSE(plausible(2.01, other));
    EXPECT_TRUE(plausible(other, 0.505));
    EXPECT_FALSE(plausible(other, 0.495));
    EXPECT_FALSE(plausible(other, -other)) << "mirrored";
  }
}

}  // namespace
}  // namespace rastro
