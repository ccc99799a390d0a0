// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/association.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace rastro {
namespace {

using Kind = LandmarkAssociation::Kind;

BodyObservation observation_at(double x, double y, LandmarkKind kind = LandmarkKind::given, std::int64_t id = -1) {
  return {kind, id, {x, y}, 0.01 * Eigen::Matrix2d::Identity(), 0.0};
}

/// Landmarks known to 0.1 m, like the observations, from an exactly known body pose: squared distance = meters^2 /
/// 0.02.
struct KnownLandmarks {
  EkfFilter filter;
  std::vector<LandmarkRecord> records;

  void add(double x, double y, LandmarkKind kind = LandmarkKind::given, std::int64_t id = -1) {
    filter.add({x, y}, 0.01 * Eigen::Matrix2d::Identity());
    records.push_back({static_cast<std::int64_t>(records.size()), kind, id, 0.0, 1, 0});
  }
  std::vector<LandmarkAssociation> associated(const std::vector<BodyObservation>& observations,
                                              const EkfOptions& options = {}) const {
    return associate(filter, records, observations, options);
  }
  Kind kind_of(const BodyObservation& observation, const EkfOptions& options = {}) const {
    return associated({observation}, options)[0].kind;
  }
};

TEST(LandmarkAssociation, TheGateIsASquaredMahalanobisDistance) {
  KnownLandmarks map;
  map.add(5.0, 0.0);
  const double gate_m = std::sqrt(9.21 * 0.02), new_gate_m = std::sqrt(27.6 * 0.02);
  EXPECT_EQ(map.kind_of(observation_at(5.0 + 0.999 * gate_m, 0.0)), Kind::landmark);
  EXPECT_EQ(map.kind_of(observation_at(5.0 + 1.001 * gate_m, 0.0)), Kind::contradicting);
  EXPECT_EQ(map.kind_of(observation_at(5.0, 0.999 * new_gate_m)), Kind::contradicting);
  EXPECT_EQ(map.kind_of(observation_at(5.0, 1.001 * new_gate_m)), Kind::fresh);
  EXPECT_NEAR(map.associated({observation_at(5.1, 0.2)})[0].distance, 0.05 / 0.02, 1e-9);
}

TEST(LandmarkAssociation, AnEmptyMapMatchesNothing) {
  EXPECT_EQ(KnownLandmarks().kind_of(observation_at(1.0, 1.0)), Kind::fresh);
}

TEST(LandmarkAssociation, AmbiguousObservationsAreNotUsed) {
  KnownLandmarks map;
  map.add(5.0, 0.0);
  map.add(5.0, 0.5);
  EXPECT_EQ(map.kind_of(observation_at(5.0, 0.2)), Kind::ambiguous);
  EXPECT_EQ(map.kind_of(observation_at(5.0, 0.05)), Kind::landmark);  // the other one is far outside the gate
  EkfOptions bold;
  bold.ambiguity = 0.0;
  EXPECT_EQ(map.associated({observation_at(5.0, 0.2)}, bold)[0].landmark, 0U);
  EXPECT_EQ(map.associated({observation_at(5.0, 0.3)}, bold)[0].landmark, 1U);
}

TEST(LandmarkAssociation, ALandmarkIsMatchedOnceByTheNearest) {
  KnownLandmarks map;
  map.add(5.0, 0.0);
  for (const bool swapped : {false, true}) {
    std::vector<BodyObservation> observations = {observation_at(5.0, 0.1), observation_at(5.0, -0.2)};
    if (swapped) std::swap(observations[0], observations[1]);
    const auto found = map.associated(observations);
    EXPECT_EQ(found[swapped ? 1 : 0].kind, Kind::landmark);
    EXPECT_EQ(found[swapped ? 0 : 1].kind, Kind::ambiguous);
  }
}

TEST(LandmarkAssociation, IdsDecideUnlessOutsideTheirGate) {
  KnownLandmarks map;
  map.add(5.0, 0.0, LandmarkKind::given, 7);
  map.add(5.0, 0.1, LandmarkKind::given, 8);
  EXPECT_EQ(map.associated({observation_at(5.0, 0.1, LandmarkKind::given, 7)})[0].landmark, 0U);
  EXPECT_EQ(map.kind_of(observation_at(9.0, 0.0, LandmarkKind::given, 7)), Kind::contradicting);
  EXPECT_EQ(map.kind_of(observation_at(5.0, 0.0, LandmarkKind::given, 9)), Kind::fresh);
}

TEST(LandmarkAssociation, KindsAndDirectionsMustMatch) {
  KnownLandmarks map;
  map.add(5.0, 0.0, LandmarkKind::corner);
  EXPECT_EQ(map.kind_of(observation_at(5.0, 0.0, LandmarkKind::spike)), Kind::fresh);
  BodyObservation corner = observation_at(5.0, 0.0, LandmarkKind::corner);
  EXPECT_EQ(map.kind_of(corner), Kind::landmark);
  corner.direction = std::numbers::pi;
  EXPECT_EQ(map.kind_of(corner), Kind::fresh);
  corner.direction = 2.0 * std::numbers::pi + 0.1;
  EXPECT_EQ(map.kind_of(corner), Kind::landmark);
}

TEST(LandmarkAssociation, CandidatesComeAfterLandmarks) {
  KnownLandmarks map;
  map.add(5.0, 0.0);
  map.add(5.0, 0.5);
  map.records[1].id = -1;
  EXPECT_EQ(map.associated({observation_at(5.0, 0.25)})[0].landmark, 0U);
  const auto beyond = map.associated({observation_at(5.0, 0.85)})[0];
  EXPECT_EQ(beyond.kind, Kind::candidate);
  EXPECT_EQ(beyond.landmark, 1U);
  EXPECT_EQ(map.kind_of(observation_at(5.0, 1.1)), Kind::ambiguous);  // too near to be another one
  EXPECT_EQ(map.kind_of(observation_at(5.0, 1.5)), Kind::fresh);
}

TEST(LandmarkAssociation, LandmarksThatTheDriftMakesUnsureAreNotComparedWith) {
  KnownLandmarks map;
  map.add(5.0, 0.0);
  map.add(5.0, 20.0);
  map.add(5.0, 0.0, LandmarkKind::given, 7);
  map.filter.predict(SE2(), Eigen::Vector3d(1.0, 1.0, 1e-6).asDiagonal());
  const auto together = map.associated({observation_at(5.0, 0.0), observation_at(5.0, 20.0)});
  EXPECT_EQ(together[0].kind, Kind::fresh);
  EXPECT_EQ(together[1].kind, Kind::fresh);
  EXPECT_EQ(map.kind_of(observation_at(6.0, 1.0, LandmarkKind::given, 7)), Kind::landmark);
  // What was added after the drift is sure from there.
  map.add(5.1, 0.1);
  EXPECT_EQ(map.associated({observation_at(5.1, 0.0)})[0].landmark, 3U);
}

TEST(LandmarkAssociation, ASensorThatIsNoBetterThanTheDriftIsAssociatedByDistance) {
  KnownLandmarks map;
  map.add(5.0, 0.0);
  map.filter.predict(SE2(), Eigen::Vector3d(0.2, 0.2, 1e-6).asDiagonal());
  BodyObservation coarse = observation_at(5.5, 0.0);
  EXPECT_EQ(map.kind_of(coarse), Kind::fresh);
  coarse.covariance = 0.2 * Eigen::Matrix2d::Identity();
  EXPECT_EQ(map.kind_of(coarse), Kind::landmark);
}

TEST(LandmarkAssociation, ALandmarkThatWasOnlyObservedFromAfarIsAssociatedByDistance) {
  KnownLandmarks map;
  map.filter.add({5.0, 0.0}, 0.3 * Eigen::Matrix2d::Identity());
  map.records.push_back({0, LandmarkKind::given, -1, 0.0, 5, 0, 0.6});
  EXPECT_EQ(map.kind_of(observation_at(5.5, 0.0)), Kind::landmark);
  map.filter.predict(SE2(), Eigen::Vector3d(1.0, 1.0, 1e-6).asDiagonal());
  EXPECT_EQ(map.kind_of(observation_at(5.5, 0.0)), Kind::fresh) << "now by drift";
}

}  // namespace
}  // namespace rastro
