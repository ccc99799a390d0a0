// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/joint_compatibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace rastro {
namespace {

using Points = std::vector<Eigen::Vector2d>;

const Points furniture = {{4.0, 1.0}, {5.5, -1.5}, {6.0, 2.0}, {7.0, 0.5}, {3.0, -2.5}, {2.5, 2.2}};

/// Landmarks of a start, a drive that comes back there with 0.7 m and 3 deg of doubt, and those that are seen then.
class WayBack {
 public:
  explicit WayBack(const Points& before) {
    add(before);
    filter_.predict(SE2(), Eigen::Vector3d(0.25, 0.25, 0.0027).asDiagonal());
  }
  void add(const Points& in_body) {
    for (const Eigen::Vector2d& point : in_body) {
      filter_.add(point, 1e-4 * Eigen::Matrix2d::Identity());
      const auto id = static_cast<std::int64_t>(records_.size());
      records_.push_back({id, LandmarkKind::spike, -1, 0.0, 5, 0, 2e-4});
    }
  }
  /// Seen from where the body is in truth.
  void see(const SE2& believed_from_true, const Points& points) {
    Points in_body;
    for (const Eigen::Vector2d& point : points) in_body.push_back(believed_from_true.inverse() * point);
    add(in_body);
  }
  std::vector<std::pair<std::size_t, std::size_t>> recognized(const EkfOptions& options = {}) const {
    std::vector<std::pair<std::size_t, std::size_t>> result;
    for (const LandmarkPair& pair : recognized_pairs(filter_, records_, options))
      result.emplace_back(pair.known, pair.recent);
    std::sort(result.begin(), result.end());
    return result;
  }
  EkfFilter& filter() { return filter_; }
  std::vector<LandmarkRecord>& records() { return records_; }

 private:
  EkfFilter filter_;
  std::vector<LandmarkRecord> records_;
};

const SE2 drift(SO2::from_angle(0.05), {0.5, -0.4});

TEST(JointCompatibility, RecognizesAPlaceAfterDrift) {
  WayBack way(furniture);
  way.see(drift, furniture);
  const auto pairs = way.recognized();
  ASSERT_EQ(pairs.size(), furniture.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_EQ(pairs[i], std::make_pair(i, furniture.size() + i));
}

TEST(JointCompatibility, TheUnitedLandmarksGiveThePose) {
  WayBack way(furniture);
  way.see(drift, furniture);
  for (const auto& [known, recent] : way.recognized())
    way.filter().unite(recent, known, 1e-4 * Eigen::Matrix2d::Identity());
  EXPECT_LT((way.filter().world_from_body().translation() - drift.translation()).norm(), 0.03);
  EXPECT_NEAR(way.filter().world_from_body().rotation().angle(), 0.05, 0.01);
  EXPECT_LT(way.filter().body_covariance().diagonal().head<2>().maxCoeff(), 0.001);
}

/// Furniture that is seen 2.25 sigma beside where it was: no more than five are jointly compatible.
Points moved(const Points& points) {
  constexpr double sigma_m = 0.0245;  // of both times and of a corner
  Points result;
  for (const Eigen::Vector2d& point : points) {
    const SO2 direction = SO2::from_angle(static_cast<double>(result.size()));
    result.push_back(point + direction * Eigen::Vector2d(2.25 * sigma_m, 0.0));
  }
  return result;
}

TEST(JointCompatibility, WhatFitsOnceThePlaceIsRecognizedIsUnitedToo) {
  WayBack way(furniture);
  way.see(drift, moved(furniture));
  const auto pairs = way.recognized();
  ASSERT_EQ(pairs.size(), furniture.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_EQ(pairs[i], std::make_pair(i, furniture.size() + i));
}

TEST(JointCompatibility, OfTwoThatFitNearlyEquallyNoneIsUnited) {
  WayBack way(furniture);
  Points seen = moved(furniture);
  seen.push_back(furniture[0] + SO2::from_angle(0.5) * Eigen::Vector2d(0.06, 0.0));
  way.see(drift, seen);
  const auto pairs = way.recognized();
  ASSERT_EQ(pairs.size(), furniture.size() - 1);
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_EQ(pairs[i], std::make_pair(i + 1, furniture.size() + i + 1));
}

TEST(JointCompatibility, FewLandmarksAreNoPlace) {
  const Points few(furniture.begin(), furniture.begin() + 3);
  WayBack way(furniture);
  way.see(drift, few);
  EXPECT_TRUE(way.recognized().empty());
  EkfOptions bold;
  bold.companions = 2;
  bold.unsure_m = 0.5;
  EXPECT_EQ(way.recognized(bold).size(), 3U);
}

TEST(JointCompatibility, ARowOfEqualPolesIsSeveralPlaces) {
  Points row, part;
  for (int i = 0; i < 8; ++i) row.emplace_back(2.0 + 0.6 * i, 1.5);
  for (int i = 2; i < 6; ++i) part.push_back(row[static_cast<std::size_t>(i)]);
  WayBack way(row);
  way.see(drift, part);
  EXPECT_TRUE(way.recognized().empty());
}

TEST(JointCompatibility, APlaceBeyondTheDriftIsAnotherOne) {
  WayBack way(furniture);
  way.see(SE2(SO2::from_angle(0.4), {0.5, -0.4}), furniture);  // eight sigma
  EXPECT_TRUE(way.recognized().empty());
}

TEST(JointCompatibility, WhereMostAroundIsElsewhereThePlaceOnlyLooksAlike) {
  WayBack way(furniture);
  Points seen(furniture.begin(), furniture.begin() + 4);
  // Near mapped ones, but each off by 0.45 m in another direction.
  for (std::size_t i = 0; i < furniture.size(); ++i)
    seen.push_back(furniture[i] + SO2::from_angle(2.4 * static_cast<double>(i)) * Eigen::Vector2d(0.45, 0.0));
  way.see(drift, seen);
  EXPECT_TRUE(way.recognized().empty());
}

TEST(JointCompatibility, CandidatesAndNamedLandmarksAreNoKnownPlace) {
  WayBack way(furniture);
  way.see(drift, furniture);
  for (std::size_t i = 0; i < 3; ++i) {
    way.records()[i].id = -1;
    way.records()[i + 3].sensor_id = 7;
  }
  EXPECT_TRUE(way.recognized().empty());
}

}  // namespace
}  // namespace rastro
