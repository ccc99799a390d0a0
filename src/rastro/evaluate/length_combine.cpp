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
/// Keyframes have similar positions and the same pixel noise: the share of the variance they have in common.
constexpr double shared_variance = 0.15;
/// Systematic error: edges are no perfect lines, and calibration has a limited accuracy.
constexpr double floor_m = 0.001, floor_per_meter = 0.002;

/// Standard deviation estimated by the median absolute deviation.
double spread(std::vector<double> values, double center) {
  for (double& value : values) value = std::abs(value - center);
  return 1.4826 * upper_median(std::move(values));
}

std::vector<double> values_of(const std::vector<LengthObservation>& observations) {
  std::vector<double> values;
  values.reserve(observations.size());
  for (const LengthObservation& one : observations) values.push_back(one.value_m);
  return values;
}

void drop_outliers(std::vector<LengthObservation>& observations) {
  if (observations.size() < 3) return;
  const std::vector<double> values = values_of(observations);
  const double center = upper_median(values), sigma = spread(values, center);
  std::erase_if(observations, [&](const LengthObservation& one) {
    return std::abs(one.value_m - center) > outlier_sigmas * std::hypot(sigma, one.sigma_m);
  });
}

/// A keyframe with its observation of a, of b, or of both.
struct Pair {
  const LengthObservation* a = nullptr;
  const LengthObservation* b = nullptr;
  double difference() const { return b->value_m - a->value_m; }
  double difference_sigma() const { return std::hypot(a->sigma_m, b->sigma_m); }
};

std::vector<Pair> paired(const std::vector<LengthObservation>& a, const std::vector<LengthObservation>& b) {
  std::map<std::int64_t, Pair> by_keyframe;
  for (const LengthObservation& one : a) by_keyframe[one.keyframe].a = &one;
  for (const LengthObservation& one : b) by_keyframe[one.keyframe].b = &one;
  std::vector<Pair> pairs;
  pairs.reserve(by_keyframe.size());
  for (const auto& [keyframe, pair] : by_keyframe) pairs.push_back(pair);
  return pairs;
}

/// Outliers: keyframes whose lengths disagree with most have measured another feature.
void drop_disagreeing(std::vector<Pair>& pairs) {
  std::vector<double> differences;
  for (const Pair& pair : pairs)
    if (pair.a != nullptr && pair.b != nullptr) differences.push_back(pair.difference());
  if (differences.size() < 3) return;
  const double center = upper_median(differences), sigma = spread(differences, center);
  std::erase_if(pairs, [&](const Pair& pair) {
    if (pair.a == nullptr || pair.b == nullptr) return false;
    return std::abs(pair.difference() - center) > outlier_sigmas * std::hypot(sigma, pair.difference_sigma());
  });
}

/// Variance of the poses: scatter of the values beyond their own sigmas (DerSimonian and Laird 1986).
double pose_variance(const std::vector<LengthObservation>& a, const std::vector<LengthObservation>& b) {
  double squares = 0.0, expected = 0.0, freedom = 0.0;
  for (const auto* all : {&a, &b}) {
    if (all->size() < 2) continue;
    const auto count = static_cast<double>(all->size());
    double mean = 0.0;
    for (const LengthObservation& one : *all) mean += one.value_m / count;
    for (const LengthObservation& one : *all) {
      squares += (one.value_m - mean) * (one.value_m - mean);
      expected += (count - 1.0) / count * one.sigma_m * one.sigma_m;
    }
    freedom += count - 1.0;
  }
  return freedom > 0.0 ? std::max(0.0, (squares - expected) / freedom) : 0.0;
}

/// The unknowns: positions of a and b, heights of their faces.
struct Solution {
  Eigen::Vector4d unknowns = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();

  double difference(const Pair& pair) const {
    return pair.difference() - pair.b->lever * unknowns[3] + pair.a->lever * unknowns[2];
  }
};

/// Inverse covariance of a keyframe's observations of a and b. A feature without observation has infinite variance,
/// which is a zero here. Sherman and Morrison: (D + v 1 1^T)^-1 = D^-1 - D^-1 1 1^T D^-1 v / (1 + v 1^T D^-1 1).
Eigen::Matrix2d weight_of(const Pair& pair, double pose_variance) {
  const double own_a = pair.a != nullptr ? 1.0 / (pair.a->sigma_m * pair.a->sigma_m) : 0.0;
  const double own_b = pair.b != nullptr ? 1.0 / (pair.b->sigma_m * pair.b->sigma_m) : 0.0;
  const Eigen::Vector2d own(own_a, own_b);
  Eigen::Matrix2d weight = own.asDiagonal();
  weight -= pose_variance / (1.0 + pose_variance * own.sum()) * own * own.transpose();
  return weight;
}

Solution solved(const std::vector<Pair>& pairs, double pose_variance, const LengthObservations& a,
                const LengthObservations& b) {
  // If all keyframes observe both, the sum of a and b is known only to the variance of the poses, which may be large.
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
  for (const auto& [observations, unknown] : {std::pair(&a, 2), std::pair(&b, 3)}) {
    const double sigma = std::max(observations->height_sigma_m, 1e-6);
    information(unknown, unknown) += 1.0 / (sigma * sigma);
    right[unknown] += observations->height_m / (sigma * sigma);
  }
  Solution solution;
  solution.covariance = information.inverse();
  solution.unknowns = solution.covariance * right;
  return solution;
}

/// Mean variance of one keyframe's length, and by how much the lengths scatter beyond it.
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

/// Mean of the error common to all keyframes, as a variance.
double shared_by_all(const LengthObservations& observations) {
  double sum = 0.0;
  for (const LengthObservation& one : observations.all) sum += one.shared_m * one.shared_m;
  return sum / std::max<double>(1.0, static_cast<double>(observations.all.size()));
}

}  // namespace

std::optional<CombinedLength> combine_lengths(LengthObservations a, LengthObservations b) {
  for (auto* end : {&a, &b}) {
    for (LengthObservation& one : end->all) one.sigma_m = std::max(one.sigma_m, 1e-6);
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
  result.length_m = solution.unknowns[1] - solution.unknowns[0];
  result.height_sigma_m = std::sqrt(std::max(covariance(2, 2), covariance(3, 3)));
  result.pose_sigma_m = std::sqrt(variance);
  double own_variance = 0.0, excess = 1.0;
  judge_scatter(pairs, solution, result, own_variance, excess);
  double total = excess * (covariance(0, 0) + covariance(1, 1) - 2.0 * covariance(0, 1));
  if (result.together == 0) {
    // Errors of neighboring keyframes are correlated: their number hardly reduces the scatter of the poses.
    result.scatter_m = std::sqrt(variance);
    total += variance;
    own_variance = std::pow(a.all.front().sigma_m, 2) + std::pow(b.all.front().sigma_m, 2);
  }
  total += shared_variance * own_variance + shared_by_all(a) + shared_by_all(b);
  total += std::pow(floor_m, 2) + std::pow(floor_per_meter * result.length_m, 2);
  result.sigma_m = std::sqrt(total);
  return result;
}

}  // namespace rastro
