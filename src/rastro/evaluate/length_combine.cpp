// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_combine.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr double outlier_sigmas = 3.5;
/// Keyframes look from about the same places at the same pixels' noise: the share of the variance they have in common.
constexpr double shared_variance = 0.15;
/// What no number of keyframes takes away: edges are no ideal lines, and cameras are calibrated that well.
constexpr double floor_m = 0.001, floor_per_metre = 0.002;

/// Standard deviation as the median of the distances to the median tells it.
double spread(std::vector<double> values, double centre) {
  for (double& value : values) value = std::abs(value - centre);
  return 1.4826 * upper_median(std::move(values));
}

std::vector<double> values_of(const std::vector<LengthSighting>& sightings) {
  std::vector<double> values;
  values.reserve(sightings.size());
  for (const LengthSighting& one : sightings) values.push_back(one.value_m);
  return values;
}

void drop_outliers(std::vector<LengthSighting>& sightings) {
  if (sightings.size() < 3) return;
  const std::vector<double> values = values_of(sightings);
  const double centre = upper_median(values), sigma = spread(values, centre);
  std::erase_if(sightings, [&](const LengthSighting& one) {
    return std::abs(one.value_m - centre) > outlier_sigmas * std::hypot(sigma, one.sigma_m);
  });
}

/// A keyframe with its sighting of a, of b, or of both.
struct Pair {
  const LengthSighting* a = nullptr;
  const LengthSighting* b = nullptr;
  double difference() const { return b->value_m - a->value_m; }
  double difference_sigma() const { return std::hypot(a->sigma_m, b->sigma_m); }
};

std::vector<Pair> paired(const std::vector<LengthSighting>& a, const std::vector<LengthSighting>& b) {
  std::map<std::int64_t, Pair> by_keyframe;
  for (const LengthSighting& one : a) by_keyframe[one.keyframe].a = &one;
  for (const LengthSighting& one : b) by_keyframe[one.keyframe].b = &one;
  std::vector<Pair> pairs;
  pairs.reserve(by_keyframe.size());
  for (const auto& [keyframe, pair] : by_keyframe) pairs.push_back(pair);
  return pairs;
}

/// Keyframes whose lengths disagree with most have taken something else for one of the features.
void drop_disagreeing(std::vector<Pair>& pairs) {
  std::vector<double> differences;
  for (const Pair& pair : pairs)
    if (pair.a != nullptr && pair.b != nullptr) differences.push_back(pair.difference());
  if (differences.size() < 3) return;
  const double centre = upper_median(differences), sigma = spread(differences, centre);
  std::erase_if(pairs, [&](const Pair& pair) {
    if (pair.a == nullptr || pair.b == nullptr) return false;
    return std::abs(pair.difference() - centre) > outlier_sigmas * std::hypot(sigma, pair.difference_sigma());
  });
}

/// Variance of the poses: what the values scatter more than their own sigmas say (DerSimonian and Laird 1986).
double pose_variance(const std::vector<LengthSighting>& a, const std::vector<LengthSighting>& b) {
  double squares = 0.0, expected = 0.0, freedom = 0.0;
  for (const auto* all : {&a, &b}) {
    if (all->size() < 2) continue;
    const auto count = static_cast<double>(all->size());
    double mean = 0.0;
    for (const LengthSighting& one : *all) mean += one.value_m / count;
    for (const LengthSighting& one : *all) {
      squares += (one.value_m - mean) * (one.value_m - mean);
      expected += (count - 1.0) / count * one.sigma_m * one.sigma_m;
    }
    freedom += count - 1.0;
  }
  return freedom > 0.0 ? std::max(0.0, (squares - expected) / freedom) : 0.0;
}

/// The unknowns: places of a and b, heights of their faces.
struct Solution {
  Eigen::Vector4d places = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();

  double difference(const Pair& pair) const {
    return pair.difference() - pair.b->lever * places[3] + pair.a->lever * places[2];
  }
};

/// Inverse covariance of what a keyframe says of a and b. A feature that is not seen has an endless variance, which is
/// a zero here. Sherman and Morrison: (D + v 1 1^T)^-1 = D^-1 - D^-1 1 1^T D^-1 v / (1 + v 1^T D^-1 1).
Eigen::Matrix2d weight_of(const Pair& pair, double pose_variance) {
  const double own_a = pair.a != nullptr ? 1.0 / (pair.a->sigma_m * pair.a->sigma_m) : 0.0;
  const double own_b = pair.b != nullptr ? 1.0 / (pair.b->sigma_m * pair.b->sigma_m) : 0.0;
  const Eigen::Vector2d own(own_a, own_b);
  Eigen::Matrix2d weight = own.asDiagonal();
  weight -= pose_variance / (1.0 + pose_variance * own.sum()) * own * own.transpose();
  return weight;
}

Solution solved(const std::vector<Pair>& pairs, double pose_variance, const LengthSightings& a,
                const LengthSightings& b) {
  // Where all keyframes see both, the sum of a and b is only known to the variance of the poses, which may be large.
  Eigen::Matrix4d information = 1e-9 * Eigen::Matrix4d::Identity();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const Pair& pair : pairs) {
    Eigen::Matrix<double, 2, 4> design = Eigen::Matrix<double, 2, 4>::Zero();
    Eigen::Vector2d values = Eigen::Vector2d::Zero();
    design(0, 0) = design(1, 1) = 1.0;
    if (pair.a != nullptr) design(0, 2) = pair.a->lever, values[0] = pair.a->value_m;
    if (pair.b != nullptr) design(1, 3) = pair.b->lever, values[1] = pair.b->value_m;
    const Eigen::Matrix2d weight = weight_of(pair, pose_variance);
    information += design.transpose() * weight * design;
    right += design.transpose() * weight * values;
  }
  for (const auto& [sightings, unknown] : {std::pair(&a, 2), std::pair(&b, 3)}) {
    const double sigma = std::max(sightings->height_sigma_m, 1e-6);
    information(unknown, unknown) += 1.0 / (sigma * sigma);
    right[unknown] += sightings->height_m / (sigma * sigma);
  }
  Solution solution;
  solution.covariance = information.inverse();
  solution.places = solution.covariance * right;
  return solution;
}

/// Mean variance of one keyframe's length, and how much more the lengths scatter than that.
void judge_scatter(const std::vector<Pair>& pairs, const Solution& solution, CombinedLength& result,
                   double& own_variance, double& excess) {
  double squares = 0.0, ratio = 0.0, own = 0.0;
  for (const Pair& pair : pairs) {
    if (pair.a == nullptr || pair.b == nullptr) continue;
    ++result.together;
    const double error = solution.difference(pair) - result.length_m, sigma = pair.difference_sigma();
    squares += error * error;
    ratio += error * error / (sigma * sigma);
    own += sigma * sigma;
  }
  if (result.together == 0) return;
  result.scatter_m = std::sqrt(squares / result.together);
  own_variance = own / result.together;
  if (result.together > 1) excess = std::max(1.0, ratio / (result.together - 1));
}

/// Mean of what may be off alike in all keyframes, as a variance.
double shared_by_all(const LengthSightings& sightings) {
  double sum = 0.0;
  for (const LengthSighting& one : sightings.all) sum += one.shared_m * one.shared_m;
  return sum / std::max<double>(1.0, static_cast<double>(sightings.all.size()));
}

}  // namespace

std::optional<CombinedLength> combine_lengths(LengthSightings a, LengthSightings b) {
  for (auto* end : {&a, &b}) {
    for (LengthSighting& one : end->all) one.sigma_m = std::max(one.sigma_m, 1e-6);
    drop_outliers(end->all);
  }
  std::vector<Pair> pairs = paired(a.all, b.all);
  drop_disagreeing(pairs);
  CombinedLength result;
  for (const Pair& pair : pairs) result.seen_a += pair.a != nullptr, result.seen_b += pair.b != nullptr;
  if (result.seen_a == 0 || result.seen_b == 0) return std::nullopt;
  const double variance = pose_variance(a.all, b.all);
  const Solution solution = solved(pairs, variance, a, b);
  const Eigen::Matrix4d& covariance = solution.covariance;
  result.length_m = solution.places[1] - solution.places[0];
  result.pose_sigma_m = std::sqrt(variance);
  double own_variance = 0.0, excess = 1.0;
  judge_scatter(pairs, solution, result, own_variance, excess);
  double total = excess * (covariance(0, 0) + covariance(1, 1) - 2.0 * covariance(0, 1));
  if (result.together == 0) {
    // Neighbouring keyframes err alike: their number takes little of the poses' scatter away.
    result.scatter_m = std::sqrt(variance);
    total += variance;
    own_variance = std::pow(a.all.front().sigma_m, 2) + std::pow(b.all.front().sigma_m, 2);
  }
  total += shared_variance * own_variance + shared_by_all(a) + shared_by_all(b);
  total += std::pow(floor_m, 2) + std::pow(floor_per_metre * result.length_m, 2);
  result.sigma_m = std::sqrt(total);
  return result;
}

}  // namespace rastro
