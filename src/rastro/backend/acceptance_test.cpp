// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/acceptance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::random_vector;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// All limits on.
constexpr AcceptanceOptions strict{.min_score = 0.5,
                                   .min_inliers = 20,
                                   .min_inlier_share = 0.25,
                                   .min_observed = 40,
                                   .min_overlap = 0.1,
                                   .min_observed_share = 0.75,
                                   .max_graph_sigmas = 3.0};

/// Just within each of them.
constexpr Evidence just_enough{
    .score = 0.5, .matches = 80, .inliers = 20, .compared = 600, .predicted = 60, .observed = 45, .graph_sigmas = 3.0};

struct Judged {
  Rejection rejection;
  void (*worsen)(Evidence&);
};

class JudgeTest : public ::testing::TestWithParam<Judged> {};

TEST_P(JudgeTest, RejectsEvidenceJustBeyondALimitForThatReason) {
  Evidence evidence = just_enough;
  ASSERT_EQ(judge(evidence, strict), Rejection::none);
  GetParam().worsen(evidence);
  EXPECT_EQ(judge(evidence, strict), GetParam().rejection);
  EXPECT_EQ(judge(evidence, {}), Rejection::none) << "all limits are off";
}

INSTANTIATE_TEST_SUITE_P(
    Reasons, JudgeTest,
    ::testing::Values(Judged{Rejection::low_score, [](Evidence& e) { e.score = 0.499; }},
                      Judged{Rejection::few_inliers, [](Evidence& e) { e.inliers = 19; }},
                      Judged{Rejection::low_inlier_share, [](Evidence& e) { e.matches = 81; }},
                      Judged{Rejection::few_observed, [](Evidence& e) { e.observed = 39; }},
                      Judged{Rejection::low_overlap, [](Evidence& e) { e.compared = 601; }},
                      // Two more predicted, but not observed.
                      Judged{Rejection::low_observed_share, [](Evidence& e) { e.predicted = 62; }},
                      Judged{Rejection::contradicts_graph, [](Evidence& e) { e.graph_sigmas = 3.001; }},
                      Judged{Rejection::contradicts_graph, [](Evidence& e) { e.graph_sigmas = infinity; }}),
    [](const auto& row) { return std::string(name_of(row.param.rejection)) + std::to_string(row.index); });

/// The proportions from which what was found is 1.645 standard deviations off (Wilson 1927).
TEST(Evidence, TheShareThatLooksAlikeHasTwoBounds) {
  const auto sigmas_off = [](double share, double proportion, int of) {
    return (share - proportion) / std::sqrt(proportion * (1.0 - proportion) / of);
  };
  for (const int alike : {3, 8, 20}) {
    const Evidence evidence{.patches = 23, .alike_patches = alike};
    const double share = alike / 23.0;
    EXPECT_NEAR(sigmas_off(share, evidence.alike_share(), 23), 1.645, 1e-9);
    EXPECT_NEAR(sigmas_off(share, evidence.most_alike_share(), 23), -1.645, 1e-9);
  }
  EXPECT_EQ(Evidence{}.alike_share(), 0.0);
  EXPECT_EQ(Evidence{}.most_alike_share(), 1.0);
}

TEST(Judge, NanPassesNoLimit) {
  EXPECT_EQ(judge({.score = not_a_number}, {.min_score = 0.1}), Rejection::low_score);
  EXPECT_EQ(judge({.graph_sigmas = not_a_number}, {.max_graph_sigmas = 3.0}), Rejection::contradicts_graph);
  EXPECT_EQ(judge({.graph_sigmas = not_a_number}, {}), Rejection::none);
}

TEST(Judge, NothingObservedOfNothingPredictedIsNoSupport) {
  EXPECT_EQ(Evidence().observed_share(), 0.0);
  EXPECT_EQ(Evidence().overlap(), 0.0);
  EXPECT_EQ(judge({}, {.min_observed_share = 0.01}), Rejection::low_observed_share);
  EXPECT_EQ(judge({.compared = 10, .predicted = 10}, {.min_overlap = 0.01}), Rejection::low_overlap);
}

/// More support or less contradiction never leads to a worse decision.
TEST(Judge, BetterEvidenceIsNeverRejectedWhereWorseIsAccepted) {
  Random random(4);
  int accepted = 0, both = 0;
  for (int k = 0; k < 4000; ++k) {
    Evidence worse = just_enough;
    worse.score += random.uniform(-0.05, 0.2);
    worse.inliers += static_cast<int>(random.below(12)) - 2;
    worse.observed += static_cast<int>(random.below(12)) - 2;
    worse.graph_sigmas += random.uniform(-2.0, 0.5);
    Evidence better = worse;
    better.score += random.uniform(0.0, 0.1);
    better.inliers += static_cast<int>(random.below(5));
    better.observed += static_cast<int>(random.below(4));
    better.matches -= static_cast<int>(random.below(9));
    better.graph_sigmas -= random.uniform();
    accepted += judge(better, strict) == Rejection::none;
    if (judge(worse, strict) != Rejection::none) continue;
    ++both;
    ASSERT_EQ(judge(better, strict), Rejection::none);
  }
  EXPECT_GT(both, 500);
  EXPECT_GT(accepted, both + 100) << "some were only accepted since they were better";
}

TEST(HypothesisState, FollowsFromItsMembersInAnyOrder) {
  Acceptance acceptance({.min_inliers = 10, .min_confirmations = 2});
  const Hypothesis proposed{7};
  EXPECT_EQ(proposed.group, std::vector<std::int64_t>{7});
  EXPECT_EQ(proposed.state(), HypothesisState::candidate);
  // Verified, then confirmed: a frame that is relocalized.
  const Hypothesis verified = acceptance.judged(proposed, {.inliers = 10});
  EXPECT_EQ(verified.state(), HypothesisState::unconfirmed);
  EXPECT_EQ(acceptance.next({verified}).front().state(), HypothesisState::unconfirmed);
  EXPECT_EQ(acceptance.next({verified}).front().state(), HypothesisState::accepted);
  // Confirmed, then verified: a loop of ORB-SLAM.
  acceptance.clear();
  EXPECT_EQ(acceptance.next({proposed}).front().state(), HypothesisState::candidate);
  const Hypothesis confirmed = acceptance.next({proposed}).front();
  EXPECT_TRUE(confirmed.confirmed);
  EXPECT_EQ(confirmed.state(), HypothesisState::candidate);
  EXPECT_EQ(acceptance.judged(confirmed, {.inliers = 10}).state(), HypothesisState::accepted);
  const Hypothesis rejected = acceptance.judged(confirmed, {.inliers = 9});
  EXPECT_EQ(rejected.state(), HypothesisState::rejected);
  EXPECT_EQ(rejected.rejection, Rejection::few_inliers);
  EXPECT_EQ(acceptance.judged(rejected, {.inliers = 99}).state(), HypothesisState::rejected) << "once is for good";
}

TEST(HypothesisState, TheFirstFrameIsAcceptedIfOneIsEnough) {
  EXPECT_EQ(Acceptance({.min_inliers = 3}).judged({1}, {.inliers = 3}).state(), HypothesisState::accepted);
}

TEST(HypothesisState, AnAcceptedOneIsRejectedWhenTheGraphContradictsItLater) {
  const Acceptance acceptance({.max_graph_sigmas = 8.0});
  const Hypothesis accepted = acceptance.judged({1}, {.graph_sigmas = 1.0});
  ASSERT_EQ(accepted.state(), HypothesisState::accepted);
  EXPECT_EQ(acceptance.judged(accepted, {.graph_sigmas = 9.0}).rejection, Rejection::contradicts_graph);
}

TEST(NamesOfAcceptance, AreDistinct) {
  std::set<std::string> names;
  for (int k = 0; k <= static_cast<int>(Rejection::not_confirmed); ++k)
    names.insert(name_of(static_cast<Rejection>(k)));
  for (int k = 0; k <= static_cast<int>(HypothesisState::rejected); ++k)
    names.insert(name_of(static_cast<HypothesisState>(k)));
  EXPECT_EQ(names.size(), 15U);
  EXPECT_FALSE(names.contains(""));
}

std::vector<int> confirmations(const std::vector<Hypothesis>& hypotheses) {
  std::vector<int> result;
  for (const Hypothesis& hypothesis : hypotheses) result.push_back(hypothesis.confirmations);
  return result;
}

TEST(Acceptance, AHypothesisContinuesIfGroupsShareAPlace) {
  Acceptance acceptance({.min_confirmations = 3});
  EXPECT_THAT(confirmations(acceptance.next({{5, {4, 5, 6}}, {20, {20, 21}}})), ElementsAre(1, 1));
  // 7 is a neighbor of 6; nothing continues 21; 40 is new.
  EXPECT_THAT(confirmations(acceptance.next({{7, {6, 7, 8}}, {40, {40}}})), ElementsAre(2, 1));
  const auto third = acceptance.next({{9, {8, 9}}, {40, {39, 40}}, {20, {20, 21}}});
  EXPECT_THAT(confirmations(third), ElementsAre(3, 2, 1));
  EXPECT_TRUE(third[0].confirmed);
  EXPECT_FALSE(third[1].confirmed);
}

TEST(Acceptance, OfSeveralThatItContinuesTheLongestCounts) {
  Acceptance acceptance({.min_confirmations = 9});
  acceptance.next({{1}});
  acceptance.next({{1}, {3}});
  EXPECT_THAT(confirmations(acceptance.next({{2, {1, 2, 3}}, {3}})), ElementsAre(3, 2));
}

TEST(Acceptance, OneMissingFrameRestartsIt) {
  Acceptance acceptance({.min_confirmations = 2});
  acceptance.next({{1}});
  EXPECT_THAT(acceptance.next({}), IsEmpty());
  ASSERT_EQ(acceptance.given_up().size(), 1U);
  EXPECT_EQ(acceptance.given_up()[0].place, 1);
  EXPECT_EQ(acceptance.given_up()[0].rejection, Rejection::not_confirmed);
  EXPECT_EQ(acceptance.given_up()[0].state(), HypothesisState::rejected);
  EXPECT_THAT(confirmations(acceptance.next({{1}})), ElementsAre(1));
  EXPECT_THAT(acceptance.given_up(), IsEmpty());
}

TEST(Acceptance, AsManyFramesAsAllowedMayMissIt) {
  Acceptance acceptance({.min_confirmations = 2, .max_missed = 2});
  acceptance.next({{1}});
  acceptance.next({});
  acceptance.next({{9}});
  EXPECT_THAT(acceptance.given_up(), IsEmpty());
  EXPECT_THAT(confirmations(acceptance.next({{1}})), ElementsAre(2)) << "two missed in a row";
  acceptance.next({});
  acceptance.next({});
  acceptance.next({});
  EXPECT_EQ(acceptance.given_up().size(), 1U);
  EXPECT_THAT(confirmations(acceptance.next({{1}})), ElementsAre(1));
}

TEST(Acceptance, ARejectedHypothesisConfirmsNothing) {
  Acceptance acceptance({.min_inliers = 10, .min_confirmations = 2});
  const Hypothesis bad = acceptance.judged({1}, {.inliers = 1}), good = acceptance.judged({1}, {.inliers = 10});
  EXPECT_EQ(acceptance.next({bad}).front().state(), HypothesisState::rejected);
  EXPECT_EQ(acceptance.next({good}).front().state(), HypothesisState::unconfirmed);
  EXPECT_EQ(acceptance.next({bad}).front().state(), HypothesisState::rejected);
  EXPECT_EQ(acceptance.next({good}).front().state(), HypothesisState::unconfirmed) << "not twice in a row";
}

TEST(Acceptance, ForgetsEverythingOnClear) {
  Acceptance acceptance({.min_confirmations = 2});
  acceptance.next({{1}});
  acceptance.clear();
  EXPECT_THAT(confirmations(acceptance.next({{1}})), ElementsAre(1));
}

TEST(Acceptance, IsAValueWithIndependentCopies) {
  Acceptance first({.min_confirmations = 2});
  first.next({{1}});
  Acceptance second = first;
  first.next({});
  EXPECT_THAT(confirmations(second.next({{1}})), ElementsAre(2));
  EXPECT_THAT(confirmations(first.next({{1}})), ElementsAre(1));
}

/// Random groups, against the longest chain of frames whose groups share a place, by brute force.
TEST(Acceptance, ConfirmationsAreTheLongestChainOfFrames) {
  Random random(8);
  std::vector<std::vector<Hypothesis>> frames;
  Acceptance acceptance({.min_confirmations = 4}), again = acceptance;
  int most = 0;
  for (int frame = 0; frame < 60; ++frame) {
    std::vector<Hypothesis> proposed(random.below(4));
    for (Hypothesis& hypothesis : proposed) {
      std::set<std::int64_t> group;
      while (group.size() < 4) group.insert(random.below(25));
      hypothesis.group.assign(group.begin(), group.end());
      hypothesis.place = hypothesis.group[random.below(4)];
      if (frame == 0) continue;
      for (const Hypothesis& before : frames.back()) {
        if (std::any_of(group.begin(), group.end(), [&](std::int64_t id) {
              return std::find(before.group.begin(), before.group.end(), id) != before.group.end();
            }))
          hypothesis.confirmations = std::max(hypothesis.confirmations, before.confirmations + 1);
      }
      most = std::max(most, hypothesis.confirmations);
    }
    const std::vector<Hypothesis> found = acceptance.next(proposed), repeated = again.next(proposed);
    EXPECT_EQ(confirmations(found), confirmations(proposed)) << frame;
    EXPECT_EQ(confirmations(found), confirmations(repeated));
    for (const Hypothesis& hypothesis : found) EXPECT_EQ(hypothesis.confirmed, hypothesis.confirmations >= 4);
    frames.push_back(std::move(proposed));
  }
  EXPECT_GE(most, 5);
}

constexpr AgreementLimits near_enough{0.4, 0.06};

MapCorrection correction(std::int64_t observer, const Eigen::Vector3d& moved, double yaw = 0.0,
                         const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
  const SO3 rotation = SO3::exp({0.0, 0.0, yaw});
  return {observer, SE3(rotation, at + moved - rotation * at), at};
}

TEST(Agreeing, ASmallCorrectionNeedsNoOther) {
  EXPECT_THAT(agreeing({}, near_enough), IsEmpty());
  const Eigen::Vector3d far(100.0, 0.0, 0.0);
  const std::vector<MapCorrection> corrections{correction(1, {0.39, 0.0, 0.0}), correction(2, {0.0, 0.41, 0.0}),
                                               correction(3, {0.0, 0.0, 0.0}, 0.059, far),
                                               correction(4, {0.0, 0.0, 0.0}, -0.061, far)};
  for (std::size_t k = 0; k < corrections.size(); ++k)
    EXPECT_THAT(agreeing({&corrections[k], 1}, near_enough), ElementsAre(k % 2 == 0 ? 1 : 0)) << k;
}

TEST(Agreeing, TwoObserversThatWouldMoveTheMapAlike) {
  const Eigen::Vector3d there(3.0, 0.0, 0.0), nearly(3.0, 0.39, 0.0), beyond(3.0, -0.41, 0.0);
  EXPECT_THAT(agreeing(std::vector{correction(1, there), correction(2, nearly)}, near_enough), ElementsAre(1, 1));
  EXPECT_THAT(agreeing(std::vector{correction(1, there), correction(2, beyond)}, near_enough), ElementsAre(0, 0));
  EXPECT_THAT(agreeing(std::vector{correction(1, there), correction(1, there)}, near_enough), ElementsAre(0, 0))
      << "an observer does not confirm itself";
  EXPECT_THAT(agreeing(std::vector{correction(1, there), correction(2, there, 0.07)}, near_enough), ElementsAre(0, 0));
  EXPECT_THAT(
      agreeing(std::vector{correction(1, there), correction(2, -there), correction(3, there, 0.05)}, near_enough),
      ElementsAre(1, 0, 1));
}

/// The same for any origin and orientation of the world.
TEST(Agreeing, DoesNotDependOnTheWorldsFrame) {
  Random random(6);
  std::vector<MapCorrection> corrections, moved;
  const SE3 new_from_world(SO3::exp({0.4, -1.0, 2.0}), {30.0, -20.0, 5.0});
  for (int k = 0; k < 40; ++k) {
    corrections.push_back(
        {k / 2, SE3::exp(0.3 * random_vector<Vector6d>(random, 1.0)), random_vector<Eigen::Vector3d>(random, 0.5)});
    moved.push_back({k / 2, new_from_world * corrections.back().corrected_from_world * new_from_world.inverse(),
                     new_from_world * corrections.back().position_in_world});
  }
  const auto agreed = agreeing(corrections, {0.2, 0.3});
  EXPECT_EQ(agreed, agreeing(moved, {0.2, 0.3}));
  EXPECT_GT(std::count(agreed.begin(), agreed.end(), 1), 5);
  EXPECT_GT(std::count(agreed.begin(), agreed.end(), 0), 5);
}

TEST(GraphSigmas, AreThoseOfOneCoordinateAlone) {
  const SE3 predicted(SO3::exp({0.3, -0.2, 1.0}), {4.0, 5.0, 6.0});
  Vector6d sigmas;
  sigmas << 0.1, 0.2, 0.3, 0.01, 0.02, 0.03;
  const Matrix6d covariance = sigmas.cwiseAbs2().asDiagonal();
  EXPECT_NEAR(graph_sigmas(predicted, predicted, covariance), 0.0, 1e-9);
  for (int k = 0; k < 6; ++k) {
    const SE3 measured = predicted * SE3::exp(2.5 * sigmas[k] * Vector6d::Unit(k));
    EXPECT_NEAR(graph_sigmas(predicted, measured, covariance), 2.5, 1e-9) << k;
  }
}

/// Squared, they have the mean of a chi-squared variable with six degrees of freedom.
TEST(GraphSigmas, OfSamplesOfTheCovarianceAreChiSquared) {
  Random random(9);
  Matrix6d root = 0.1 * Matrix6d::Identity();
  for (int column = 0; column < 6; ++column) root.col(column) += random_vector<Vector6d>(random, 0.05);
  const Matrix6d covariance = root * root.transpose();
  const SE3 predicted = SE3::exp(random_vector<Vector6d>(random, 1.0));
  constexpr int draws = 2000;
  double sum = 0.0;
  for (int k = 0; k < draws; ++k) {
    Vector6d normal;
    for (double& value : normal) value = random.normal();
    const double sigmas = graph_sigmas(predicted, predicted * SE3::exp(root * normal), covariance);
    sum += sigmas * sigmas;
  }
  EXPECT_NEAR(sum / draws, 6.0, 4.0 * std::sqrt(12.0 / draws));
}

TEST(GraphSigmas, AreInfiniteForInvalidInput) {
  const Matrix6d sure = Matrix6d::Identity();
  EXPECT_EQ(graph_sigmas(SE3(), SE3(), Matrix6d::Zero()), infinity);
  EXPECT_EQ(graph_sigmas(SE3(), SE3(), -sure), infinity);
  EXPECT_EQ(graph_sigmas(SE3(), SE3(), not_a_number * sure), infinity);
  EXPECT_EQ(graph_sigmas(SE3(), SE3(SO3(), {not_a_number, 0.0, 0.0}), sure), infinity);
}

/// A loop with the stated drift: a loop closure at the correct place passes the gate; one at a similar place, 6 m off,
/// does not.
TEST(OdometryDrift, DistinguishesALoopFromASimilarPlace) {
  constexpr OdometryDrift drift{.share = 0.01, .rad_per_m = 0.001};
  const Matrix6d covariance = drift.covariance(50.0);
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.5, 1e-12);
  EXPECT_NEAR(std::sqrt(covariance(5, 5)), 0.05, 1e-12);
  EXPECT_EQ(covariance(0, 5), 0.0);
  const AcceptanceOptions options{.max_graph_sigmas = 4.0};
  const SE3 correct, drifted(SO3::exp({0.0, 0.06, 0.0}), {0.7, -0.4, 0.2}), twin(SO3(), {6.0, 0.0, 0.0});
  EXPECT_EQ(judge({.graph_sigmas = graph_sigmas(drifted, correct, covariance)}, options), Rejection::none);
  EXPECT_EQ(judge({.graph_sigmas = graph_sigmas(drifted, twin, covariance)}, options), Rejection::contradicts_graph);
  EXPECT_EQ(graph_sigmas(drifted, correct, drift.covariance(0.0)), infinity) << "nothing has drifted yet";
}

/// Two similar rooms, one with a shelf that the other lacks: equally many landmarks match in both, but in the wrong one
/// a third of what should be visible is not observed.
TEST(NegativeEvidence, RejectsASimilarPlaceThatLacksVisibleLandmarks) {
  const Acceptance without({.min_inliers = 20, .min_observed = 40});
  const Acceptance with({.min_inliers = 20, .min_observed = 40, .min_observed_share = 0.75});
  const Evidence right{.inliers = 50, .compared = 200, .predicted = 120, .observed = 100};
  const Evidence twin{.inliers = 50, .compared = 200, .predicted = 150, .observed = 100};
  EXPECT_EQ(without.judged({1}, right).state(), HypothesisState::accepted);
  EXPECT_EQ(without.judged({1}, twin).state(), HypothesisState::accepted);
  EXPECT_EQ(with.judged({1}, right).state(), HypothesisState::accepted);
  EXPECT_EQ(with.judged({1}, twin).rejection, Rejection::low_observed_share);
  // The shelf is there but a person occludes it: nothing is predicted that is not observed.
  Evidence occluded = twin;
  occluded.predicted = 100;
  EXPECT_EQ(with.judged({1}, occluded).state(), HypothesisState::accepted);
}

}  // namespace
}  // namespace rastro
