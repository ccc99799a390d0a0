// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/motion_history.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/multiview/homography.h"
#include "rastro/track/klt.h"
#include "rastro/track/reappearance.h"

namespace rastro {
namespace {

/// A scene that rotates and drifts, and an object in front that moves to the right; features live only a few frames.
class TwoLayers {
 public:
  explicit TwoLayers(int life) : store_(30), history_(options_), life_(life) {}

  static Eigen::Matrix3d layer_pose(int layer, std::int64_t frame) {
    const double t = static_cast<double>(frame);
    Eigen::Isometry2d pose = Eigen::Isometry2d::Identity();
    pose.pretranslate(layer == 0 ? Eigen::Vector2d(3.0 * t, -2.0 * t) : Eigen::Vector2d(-9.0 * t, 0.5 * t));
    if (layer == 0) pose.rotate(0.02 * t);
    return pose.matrix();
  }

  /// The object in front has `front` features, the scene `scene`.
  void advance(int scene, int front) {
    ++frame_;
    std::vector<Live> followed;
    for (const Live& feature : live_) {
      if (frame_ - feature.born < life_ && feature.number < (feature.layer == 0 ? scene : front))
        followed.push_back(feature);
    }
    associations_.clear();
    for (const Live& feature : followed) associations_.push_back({feature.track, at(feature), at(feature)});
    history_.advance(frame_, associations_, store_);
    live_ = followed;
    for (int layer = 0; layer < 2; ++layer) {
      for (int number = 0; number < (layer == 0 ? scene : front); ++number) {
        const bool there = std::any_of(live_.begin(), live_.end(), [&](const Live& feature) {
          return feature.layer == layer && feature.number == number;
        });
        if (there) continue;
        const Eigen::Vector3d now(random_.uniform() * 600.0, random_.uniform() * 400.0, 1.0);
        // Staggered, so that they do not all end in one frame.
        const std::int64_t born = frame_ == 0 ? -(number % life_) : frame_;
        live_.push_back({store_.create(), layer, number, born, layer_pose(layer, frame_).inverse() * now});
      }
    }
    for (const Live& feature : live_) store_[feature.track].observe(frame_, at(feature), at(feature), {});
  }

  /// Error of the history's motion of a layer since `frame`; the number of the layer is free.
  double error_since(std::int64_t frame, int layer) {
    const auto [one, other] = errors_since(frame, layer);
    return std::min(one, other);
  }
  /// Errors of the motions of both of the history's layers as that of `layer`.
  std::pair<double, double> errors_since(std::int64_t frame, int layer) {
    double errors[MotionHistory::layers] = {1e9, 1e9};
    for (int known = 0; known < MotionHistory::layers; ++known) {
      const auto* motion = history_.since(frame, known, associations_, store_);
      if (!motion) continue;
      const Eigen::Vector2d from(300.0, 200.0);
      const Eigen::Matrix3d ground_truth = layer_pose(layer, frame_) * layer_pose(layer, frame).inverse();
      errors[known] = (*transfer(motion->current_from_frame, from) - *transfer(ground_truth, from)).norm();
    }
    return {errors[0], errors[1]};
  }

 private:
  struct Live {
    std::size_t track;
    int layer, number;
    std::int64_t born;
    Eigen::Vector3d point;
  };
  Eigen::Vector2f at(const Live& feature) const {
    return (layer_pose(feature.layer, frame_) * feature.point).hnormalized().cast<float>();
  }

  TrackOptions options_;
  TrackStore store_;
  MotionHistory history_;
  Random random_{5};
  int life_;
  std::int64_t frame_ = -1;
  std::vector<Live> live_;
  std::vector<Association> associations_;
};

TEST(MotionHistory, TwoMotionsOutliveTheFeaturesTheyWereEstimatedFrom) {
  TwoLayers world(4);
  for (int frame = 0; frame <= 15; ++frame) world.advance(60, 30);
  EXPECT_LT(world.error_since(3, 0), 0.1);
  EXPECT_LT(world.error_since(3, 1), 0.1);
}

TEST(MotionHistory, ALayerKeepsItsNameWhenTheOtherGrows) {
  TwoLayers world(6);
  for (int frame = 0; frame <= 6; ++frame) world.advance(60, 20);
  for (int frame = 7; frame <= 12; ++frame) world.advance(20, 60);
  EXPECT_LT(world.error_since(2, 0), 0.1);
  EXPECT_LT(world.error_since(2, 1), 0.1);
}

TEST(MotionHistory, ALayerOfFewFeaturesMovesByTheirMedian) {
  TwoLayers world(30);
  for (int frame = 0; frame <= 6; ++frame) world.advance(60, 20);
  for (int frame = 7; frame <= 9; ++frame) world.advance(60, 4);
  EXPECT_LT(world.error_since(4, 1), 1.0);
}

TEST(MotionHistory, WhereAllMovesAlikeBothLayersDo) {
  TwoLayers world(30);
  for (int frame = 0; frame <= 6; ++frame) world.advance(60, 0);
  const auto [one, other] = world.errors_since(2, 0);
  EXPECT_LT(one, 0.1);
  EXPECT_LT(other, 0.1);
}

TEST(MotionHistory, AHiddenLayerMovesOnAsItDidLast) {
  TwoLayers world(30);
  for (int frame = 0; frame <= 6; ++frame) world.advance(60, 30);
  for (int frame = 7; frame <= 9; ++frame) world.advance(60, 0);
  EXPECT_LT(world.error_since(4, 0), 0.1);
  EXPECT_LT(world.error_since(4, 1), 0.1);
}

TEST(MotionHistory, GivesNothingForAnUnknownMotion) {
  TwoLayers world(30);
  for (int frame = 0; frame <= 3; ++frame) world.advance(60, 0);
  for (int frame = 4; frame <= 5; ++frame) world.advance(3, 0);
  EXPECT_EQ(world.error_since(2, 0), 1e9);
}

/// A scene that rotates by 0.1 rad and grows by 3 % per frame about the middle of the image.
Eigen::Vector2f turned(const Eigen::Vector2f& start, std::int64_t frame) {
  const Eigen::Vector2f middle(320.0F, 240.0F);
  const auto t = static_cast<float>(frame);
  return middle + std::pow(1.03F, t) * (Eigen::Rotation2Df(0.1F * t) * (start - middle));
}

TEST(Reappearance, IsSoughtWhereTheSceneMovedTurnedAndGrownAsItIs) {
  constexpr std::int64_t lost_in = 2, now = 5;
  const TrackOptions options;
  TrackStore store(30);
  MotionHistory history(options);
  Random random(3);
  std::vector<Eigen::Vector2f> starts;
  for (int i = 0; i < 40; ++i)
    starts.emplace_back(static_cast<float>(random.uniform(150.0, 500.0)),
                        static_cast<float>(random.uniform(100.0, 400.0)));
  for (std::size_t i = 0; i <= starts.size(); ++i) store.create();
  const std::size_t lost = starts.size();
  const Eigen::Vector2f start(400.0F, 200.0F);
  std::vector<Association> followed;
  for (std::int64_t frame = 0; frame <= now; ++frame) {
    followed.clear();
    for (std::size_t i = 0; i < starts.size(); ++i)
      followed.push_back({i, turned(starts[i], frame), turned(starts[i], frame)});
    history.advance(frame, followed, store);
    for (const Association& feature : followed) store[feature.track].observe(frame, feature.pixel, feature.ideal, {});
    if (frame <= lost_in) store[lost].observe(frame, turned(start, frame), turned(start, frame), {});
  }
  store.mark_lost(lost);
  int asked = 0;
  const DescribeRotated describe = [&](const Eigen::Vector2f& pixel, double angle_rad, double scale) {
    ++asked;
    EXPECT_LT((pixel - turned(start, now)).norm(), 0.1F);
    EXPECT_NEAR(angle_rad, 0.1 * (now - lost_in), 1e-3);
    EXPECT_NEAR(scale, std::pow(1.03, now - lost_in), 1e-3);
    Descriptor other;
    for (auto& word : other.words) word = ~std::uint64_t{0};
    return other;
  };
  Pyramid image;
  image.build(GrayImage(640, 480).view(), 1, klt_padding, nullptr);
  for (const bool room : {false, true}) {
    const HasRoom has_room = [&](const Eigen::Vector2f&) { return room; };
    EXPECT_TRUE(find_reappeared(followed, store, now, history, UndistortedCamera(std::nullopt), image, has_room,
                                describe, options)
                    .empty())
        << "it does not look alike";
    EXPECT_EQ(asked, room ? 1 : 0);
  }
}

TEST(DerivativeAt, IsThatOfFiniteDifferences) {
  Eigen::Matrix3d homography;
  homography << 1.05, -0.2, 30.0, 0.18, 0.95, -12.0, 2e-4, -1e-4, 1.0;
  const Eigen::Vector2d point(210.0, 140.0);
  const auto derivative = derivative_at(homography, point.cast<float>());
  ASSERT_TRUE(derivative);
  constexpr double step = 1e-3;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d shift = step * Eigen::Vector2d::Unit(axis);
    const Eigen::Vector2d slope =
        (*transfer(homography, point + shift) - *transfer(homography, point - shift)) / (2 * step);
    EXPECT_LT((derivative->col(axis).cast<double>() - slope).norm(), 1e-5);
  }
  EXPECT_FALSE(derivative_at(Eigen::DiagonalMatrix<double, 3>(3.0, 3.0, 1.0), {0.0F, 0.0F}));
  EXPECT_FALSE(derivative_at(Eigen::DiagonalMatrix<double, 3>(-1.0, 1.0, 1.0), {0.0F, 0.0F}));
}

}  // namespace
}  // namespace rastro
