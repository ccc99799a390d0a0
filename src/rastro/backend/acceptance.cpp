// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/acceptance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace rastro {
namespace {

/// Both ascending.
bool share_one(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  auto i = a.begin(), j = b.begin();
  while (i != a.end() && j != b.end()) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

/// Lower (side -1) or upper (side 1) bound of a proportion with 95 % confidence (Wilson 1927).
double share_bound(int found, int of, double side) {
  constexpr double z = 1.645;
  const double n = of, share = found / n;
  const double spread = std::sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n));
  return (share + z * z / (2.0 * n) + side * z * spread) / (1.0 + z * z / n);
}

bool within(const Eigen::Vector3d& moved_by, const SO3& rotated_by, const AgreementLimits& limits) {
  return moved_by.norm() < limits.max_distance_m && rotated_by.log().norm() < limits.max_angle_rad;
}

bool moves_little(const MapCorrection& correction, const AgreementLimits& limits) {
  const Eigen::Vector3d& at = correction.position_in_world;
  return within(correction.corrected_from_world * at - at, correction.corrected_from_world.rotation(), limits);
}

/// At the position of the first one's observer.
bool agree(const MapCorrection& a, const MapCorrection& b, const AgreementLimits& limits) {
  if (a.observer == b.observer) return false;
  const Eigen::Vector3d& at = a.position_in_world;
  const SE3 &corrected_by_a = a.corrected_from_world, &corrected_by_b = b.corrected_from_world;
  return within(corrected_by_a * at - corrected_by_b * at,
                corrected_by_a.rotation().inverse() * corrected_by_b.rotation(), limits);
}

}  // namespace

const char* name_of(HypothesisState state) {
  switch (state) {
    case HypothesisState::candidate:
      return "candidate";
    case HypothesisState::unconfirmed:
      return "unconfirmed";
    case HypothesisState::accepted:
      return "accepted";
    case HypothesisState::rejected:
      return "rejected";
  }
  return "";
}

const char* name_of(Rejection rejection) {
  switch (rejection) {
    case Rejection::none:
      return "none";
    case Rejection::low_score:
      return "low_score";
    case Rejection::few_inliers:
      return "few_inliers";
    case Rejection::low_inlier_share:
      return "low_inlier_share";
    case Rejection::near_chance:
      return "near_chance";
    case Rejection::few_observed:
      return "few_observed";
    case Rejection::low_overlap:
      return "low_overlap";
    case Rejection::low_observed_share:
      return "low_observed_share";
    case Rejection::looks_different:
      return "looks_different";
    case Rejection::contradicts_graph:
      return "contradicts_graph";
    case Rejection::not_confirmed:
      return "not_confirmed";
  }
  return "";
}

double Evidence::alike_share() const { return patches <= 0 ? 0.0 : share_bound(alike_patches, patches, -1.0); }

double Evidence::most_alike_share() const { return patches <= 0 ? 1.0 : share_bound(alike_patches, patches, 1.0); }

Rejection judge(const Evidence& evidence, const AcceptanceOptions& options) {
  // Written so that NaN fails, except against an infinite limit, which is off.
  if (!(evidence.score >= options.min_score)) return Rejection::low_score;
  if (evidence.inliers < options.min_inliers) return Rejection::few_inliers;
  if (evidence.inliers < options.min_inlier_share * static_cast<double>(evidence.matches))
    return Rejection::low_inlier_share;
  if (evidence.observed < options.min_observed) return Rejection::few_observed;
  if (!(evidence.observed >= options.min_chance_ratio * evidence.chance_observed)) return Rejection::near_chance;
  if (evidence.overlap() < options.min_overlap) return Rejection::low_overlap;
  if (evidence.observed_share() < options.min_observed_share) return Rejection::low_observed_share;
  if (!(evidence.alike_share() >= options.min_alike_share)) return Rejection::looks_different;
  if (std::isfinite(options.max_graph_sigmas) && !(evidence.graph_sigmas <= options.max_graph_sigmas))
    return Rejection::contradicts_graph;
  return Rejection::none;
}

HypothesisState Hypothesis::state() const {
  if (rejection != Rejection::none) return HypothesisState::rejected;
  if (!verified) return HypothesisState::candidate;
  return confirmed ? HypothesisState::accepted : HypothesisState::unconfirmed;
}

std::vector<Hypothesis> Acceptance::next(std::vector<Hypothesis> hypotheses) {
  std::vector<Tracked> now;
  std::vector<std::uint8_t> continued(before_.size(), 0);
  for (Hypothesis& hypothesis : hypotheses) {
    if (hypothesis.rejection != Rejection::none) continue;
    hypothesis.confirmations = 1;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      const Hypothesis& before = before_[i].hypothesis;
      if (!share_one(before.group, hypothesis.group)) continue;
      continued[i] = 1;
      hypothesis.confirmations = std::max(hypothesis.confirmations, before.confirmations + 1);
    }
    hypothesis.confirmed = hypothesis.confirmations >= options_.min_confirmations;
    now.push_back({hypothesis, 0});
  }
  given_up_.clear();
  for (std::size_t i = 0; i < before_.size(); ++i) {
    if (continued[i] != 0) continue;
    Tracked& tracked = before_[i];
    if (++tracked.missed <= options_.max_missed) {
      now.push_back(std::move(tracked));
    } else {
      tracked.hypothesis.rejection = Rejection::not_confirmed;
      given_up_.push_back(std::move(tracked.hypothesis));
    }
  }
  before_ = std::move(now);
  return hypotheses;
}

Hypothesis Acceptance::judged(Hypothesis hypothesis, const Evidence& evidence) const {
  hypothesis.verified = true;
  hypothesis.confirmed = hypothesis.confirmations >= options_.min_confirmations;
  if (hypothesis.rejection == Rejection::none) hypothesis.rejection = judge(evidence, options_);
  return hypothesis;
}

void Acceptance::clear() {
  before_.clear();
  given_up_.clear();
}

std::vector<std::uint8_t> agreeing(std::span<const MapCorrection> corrections, const AgreementLimits& limits) {
  std::vector<std::uint8_t> result;
  result.reserve(corrections.size());
  for (const MapCorrection& one : corrections) {
    const bool agreed =
        moves_little(one, limits) || std::any_of(corrections.begin(), corrections.end(),
                                                 [&](const MapCorrection& other) { return agree(one, other, limits); });
    result.push_back(agreed ? 1 : 0);
  }
  return result;
}

double graph_sigmas(const SE3& predicted, const SE3& measured, const Matrix6d& covariance) {
  const Vector6d difference = (predicted.inverse() * measured).log();
  const Eigen::LLT<Matrix6d> factor(covariance);
  if (!difference.allFinite() || !covariance.allFinite() || factor.info() != Eigen::Success)
    return std::numeric_limits<double>::infinity();
  return factor.matrixL().solve(difference).norm();
}

Matrix6d OdometryDrift::covariance(double path_m) const {
  const double sigma_m = share * path_m, sigma_rad = rad_per_m * path_m;
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(sigma_m * sigma_m), Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return variances.asDiagonal();
}

}  // namespace rastro
