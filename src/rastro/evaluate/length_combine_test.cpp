// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_combine.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Settings of random keyframes that observe the ends of a length of 0.8 m.
struct Drawing {
  double true_a = 0.3, true_b = 1.1;
  double pose_sigma = 0.01;  ///< Moves both ends of a keyframe together.
  double sigma = 0.002;
  int both = 20, only_a = 0, only_b = 0;
};

struct Ends {
  LengthObservations a, b;
};

Ends drawn(const Drawing& scene, Random& random) {
  Ends ends;
  for (int k = 0; k < scene.both + scene.only_a + scene.only_b; ++k) {
    const double pose = scene.pose_sigma * random.normal();
    const auto seen = [&](double ground_truth) {
      return LengthObservation{k, ground_truth + pose + scene.sigma * random.normal(), scene.sigma, 0.0, 0.0};
    };
    if (k < scene.both + scene.only_a) ends.a.all.push_back(seen(scene.true_a));
    if (k < scene.both || k >= scene.both + scene.only_a) ends.b.all.push_back(seen(scene.true_b));
  }
  return ends;
}

TEST(CombineLengths, ExactObservationsGiveTheExactLength) {
  Random random(1);
  Drawing exact;
  exact.pose_sigma = exact.sigma = 0.0;
  for (const auto& [both, a, b] : {std::tuple{5, 0, 0}, {0, 4, 6}, {1, 0, 0}, {3, 2, 1}}) {
    exact.both = both, exact.only_a = a, exact.only_b = b;
    const Ends ends = drawn(exact, random);
    const auto length = combine_lengths(ends.a, ends.b);
    ASSERT_TRUE(length);
    EXPECT_NEAR(length->length_m, 0.8, 1e-6) << both << a << b;
    EXPECT_EQ(length->together, both);
    EXPECT_EQ(length->seen_a, both + a);
    EXPECT_EQ(length->seen_b, both + b);
    EXPECT_GE(length->sigma_m, 0.001) << "edges are no perfect lines";
  }
}

/// Keyframes that observe both ends give the length without their poses: only their own noise remains.
TEST(CombineLengths, PosesDropOutWhereBothEndsAreObserved) {
  Random random(2);
  Drawing scene;
  scene.pose_sigma = 0.05;
  double squares = 0.0, variance = 0.0;
  constexpr int runs = 200;
  for (int run = 0; run < runs; ++run) {
    const Ends ends = drawn(scene, random);
    const auto length = combine_lengths(ends.a, ends.b);
    ASSERT_TRUE(length);
    squares += std::pow(length->length_m - 0.8, 2) / runs;
    variance += std::pow(length->sigma_m, 2) / runs;
    EXPECT_NEAR(length->pose_sigma_m, 0.05, 0.035);
  }
  // Twenty differences of two values of 2 mm each.
  EXPECT_NEAR(std::sqrt(squares), 0.002 * std::sqrt(2.0 / 20.0), 0.00015);
  EXPECT_GT(variance, squares) << "it is never overconfident";
  EXPECT_LT(variance, 20.0 * squares);
}

TEST(CombineLengths, PosesCountWhereNoKeyframeObservesBoth) {
  Random random(3);
  Drawing scene;
  scene.pose_sigma = 0.03;
  scene.both = 0;
  scene.only_a = scene.only_b = 12;
  int within = 0;
  constexpr int runs = 200;
  for (int run = 0; run < runs; ++run) {
    const Ends ends = drawn(scene, random);
    const auto length = combine_lengths(ends.a, ends.b);
    ASSERT_TRUE(length);
    EXPECT_EQ(length->together, 0);
    EXPECT_GT(length->sigma_m, 0.012) << "the poses' scatter, which more keyframes hardly reduce";
    within += std::abs(length->length_m - 0.8) < 2.0 * length->sigma_m ? 1 : 0;
  }
  EXPECT_GT(within, 190);
}

/// Against the textbook: all keyframes' values in one vector with its full covariance.
TEST(CombineLengths, IsGeneralizedLeastSquaresOverAllValues) {
  Random random(4);
  Drawing scene;
  scene.both = 6, scene.only_a = 4, scene.only_b = 5;
  const Ends ends = drawn(scene, random);
  const auto length = combine_lengths(ends.a, ends.b);
  ASSERT_TRUE(length);
  ASSERT_EQ(length->seen_a + length->seen_b, 21) << "no outlier among them";
  const auto count = static_cast<Eigen::Index>(ends.a.all.size() + ends.b.all.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count, count), design = Eigen::MatrixXd::Zero(count, 2);
  Eigen::VectorXd values(count);
  std::vector<std::pair<std::int64_t, double>> rows;
  for (const LengthObservation& one : ends.a.all) rows.emplace_back(one.keyframe, one.value_m);
  for (const LengthObservation& one : ends.b.all) rows.emplace_back(one.keyframe, one.value_m);
  for (Eigen::Index i = 0; i < count; ++i) {
    values[i] = rows[static_cast<std::size_t>(i)].second;
    design(i, i < static_cast<Eigen::Index>(ends.a.all.size()) ? 0 : 1) = 1.0;
    for (Eigen::Index j = 0; j < count; ++j) {
      if (rows[static_cast<std::size_t>(i)].first == rows[static_cast<std::size_t>(j)].first)
        covariance(i, j) = length->pose_sigma_m * length->pose_sigma_m;
    }
    covariance(i, i) += scene.sigma * scene.sigma;
  }
  const Eigen::MatrixXd weight = covariance.inverse();
  const Eigen::Vector2d positions =
      (design.transpose() * weight * design).ldlt().solve(design.transpose() * weight * values);
  EXPECT_NEAR(length->length_m, positions[1] - positions[0], 1e-6);
}

TEST(CombineLengths, OutliersAreLeftOut) {
  Random random(5);
  Drawing scene;
  Ends ends = drawn(scene, random);
  ends.a.all[3].value_m += 0.5;    // another feature was measured as the end
  ends.b.all[7].value_m -= 0.025;  // within the poses' scatter, but not beside its own a
  const auto length = combine_lengths(ends.a, ends.b);
  ASSERT_TRUE(length);
  EXPECT_NEAR(length->length_m, 0.8, 0.0025);
  EXPECT_EQ(length->seen_a, 18);
  EXPECT_EQ(length->seen_b, 19);
  EXPECT_EQ(length->together, 18);
}

/// A face without depth: views from both sides determine its height; from one side it keeps its prior.
TEST(CombineLengths, EstimatesAnUnknownHeightWithViewsFromBothSides) {
  constexpr double height = 0.04, sigma = 0.001;
  Random random(6);
  for (const bool both_sides : {true, false}) {
    Ends ends;
    for (int k = 0; k < 24; ++k) {
      const double lever = both_sides && k % 2 == 0 ? -0.8 : 0.8;
      const double noise_a = sigma * random.normal(), noise_b = sigma * random.normal();
      ends.a.all.push_back({k, 0.3 + noise_a, sigma, 0.0, 0.0});
      ends.b.all.push_back({k, 1.1 + lever * height + noise_b, sigma, 0.0, lever});
    }
    ends.b.height_sigma_m = 0.1;
    const auto length = combine_lengths(ends.a, ends.b);
    ASSERT_TRUE(length);
    if (both_sides) {
      EXPECT_NEAR(length->length_m, 0.8, 0.002);
      EXPECT_LT(length->sigma_m, 0.005);
    } else {
      EXPECT_GT(length->sigma_m, 0.06) << "0.8 times 0.1 m";
      EXPECT_LT(std::abs(length->length_m - 0.8), length->sigma_m);
    }
  }
}

TEST(CombineLengths, ACommonErrorIsNotAveragedOut) {
  Random random(7);
  Drawing scene;
  scene.both = 100;
  Ends ends = drawn(scene, random);
  const auto without = combine_lengths(ends.a, ends.b);
  for (LengthObservation& one : ends.a.all) one.shared_m = 0.01;
  const auto with = combine_lengths(ends.a, ends.b);
  ASSERT_TRUE(with && without);
  EXPECT_EQ(with->length_m, without->length_m);
  EXPECT_NEAR(std::pow(with->sigma_m, 2) - std::pow(without->sigma_m, 2), 1e-4, 1e-9);
}

TEST(CombineLengths, AnEndWithoutObservationGivesNone) {
  Random random(8);
  const Ends ends = drawn({}, random);
  EXPECT_FALSE(combine_lengths({}, ends.b));
  EXPECT_FALSE(combine_lengths(ends.a, {}));
  EXPECT_FALSE(combine_lengths({}, {}));
}

TEST(CombineLengths, SwappedEndsGiveTheNegative) {
  Random random(9);
  Drawing scene;
  scene.both = 8, scene.only_a = 3, scene.only_b = 2;
  const Ends ends = drawn(scene, random);
  const auto there = combine_lengths(ends.a, ends.b), back = combine_lengths(ends.b, ends.a);
  ASSERT_TRUE(there && back);
  EXPECT_NEAR(there->length_m, -back->length_m, 1e-9);
  EXPECT_NEAR(there->sigma_m, back->sigma_m, 1e-9);
}

}  // namespace
}  // namespace rastro
