// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/association.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "rastro/slam/ekf/joint_compatibility.h"

namespace rastro {
namespace {

constexpr double nothing_near = std::numeric_limits<double>::infinity();

class Associator {
 public:
  Associator(const EkfFilter& filter, std::span<const LandmarkRecord> records, const EkfOptions& options)
      : records_(records), options_(options), heading_(filter.world_from_body().rotation().angle()) {
    expected_.reserve(records.size());
    for (std::size_t i = 0; i < records.size(); ++i) expected_.push_back(filter.expected(i));
  }

  LandmarkAssociation operator()(const BodyObservation& observation) const {
    return observation.sensor_id >= 0 ? by_name(observation) : by_distance(observation);
  }

 private:
  double distance(const BodyObservation& observation, std::size_t landmark) const {
    const auto& expected = expected_[landmark];
    return squared_mahalanobis(observation.in_body - expected.in_body, expected.covariance + observation.covariance);
  }

  bool alike(const BodyObservation& observation, const LandmarkRecord& record) const {
    if (observation.kind != record.kind || record.sensor_id >= 0) return false;
    if (observation.kind != LandmarkKind::corner) return true;
    const double off = angle_between(observation.direction + heading_, record.direction);
    return off <= options_.max_direction_deg * std::numbers::pi / 180.0;
  }

  LandmarkAssociation by_name(const BodyObservation& observation) const {
    for (std::size_t i = 0; i < records_.size(); ++i) {
      if (records_[i].sensor_id != observation.sensor_id) continue;
      const double found = distance(observation, i);
      return {found <= options_.named_gate ? kind_of(records_[i]) : LandmarkAssociation::Kind::contradicting, i, found};
    }
    return {};
  }

  static LandmarkAssociation::Kind kind_of(const LandmarkRecord& record) {
    return record.is_candidate() ? LandmarkAssociation::Kind::candidate : LandmarkAssociation::Kind::landmark;
  }

  LandmarkAssociation by_distance(const BodyObservation& observation) const {
    const LandmarkAssociation in_map = nearest(observation, false);
    return in_map.kind == LandmarkAssociation::Kind::fresh ? nearest(observation, true) : in_map;
  }

  LandmarkAssociation nearest(const BodyObservation& observation, bool candidates) const {
    LandmarkAssociation best{LandmarkAssociation::Kind::fresh, 0, nothing_near};
    double second = nothing_near;
    for (std::size_t i = 0; i < records_.size(); ++i) {
      if (records_[i].is_candidate() != candidates || !alike(observation, records_[i])) continue;
      if (is_unsure(expected_[i], std::max(observation.covariance.trace(), records_[i].noise_m2), options_)) continue;
      const double found = distance(observation, i);
      if (found < best.distance) {
        second = best.distance;
        best = {LandmarkAssociation::Kind::fresh, i, found};
      } else if (found < second) {
        second = found;
      }
    }
    if (best.distance > options_.new_gate) return best;
    const bool clear = second > options_.gate || second - best.distance >= options_.ambiguity;
    best.kind = clear ? kind_of(records_[best.landmark]) : LandmarkAssociation::Kind::ambiguous;
    if (best.distance > options_.gate) {
      best.kind = candidates ? LandmarkAssociation::Kind::ambiguous : LandmarkAssociation::Kind::contradicting;
    }
    return best;
  }

  std::span<const LandmarkRecord> records_;
  const EkfOptions& options_;
  double heading_;
  std::vector<EkfFilter::Expected> expected_;
};

/// Of several observations associated with one landmark, the nearest keeps it.
void settle_claims(std::vector<LandmarkAssociation>& associations, std::size_t landmarks) {
  std::vector<std::optional<std::size_t>> claimed(landmarks);
  for (std::size_t i = 0; i < associations.size(); ++i) {
    const LandmarkAssociation::Kind kind = associations[i].kind;
    if (kind != LandmarkAssociation::Kind::landmark && kind != LandmarkAssociation::Kind::candidate) continue;
    auto& holder = claimed[associations[i].landmark];
    std::size_t loser = i;
    if (!holder) {
      holder = i;
      continue;
    }
    if (associations[i].distance < associations[*holder].distance) std::swap(loser, *holder);
    associations[loser].kind = LandmarkAssociation::Kind::ambiguous;
  }
}

}  // namespace

std::vector<LandmarkAssociation> associate(const EkfFilter& filter, std::span<const LandmarkRecord> records,
                                           std::span<const BodyObservation> observations, const EkfOptions& options) {
  const Associator associator(filter, records, options);
  std::vector<LandmarkAssociation> result;
  result.reserve(observations.size());
  for (const BodyObservation& observation : observations) result.push_back(associator(observation));
  settle_claims(result, records.size());
  return result;
}

double angle_between(double a, double b) { return std::abs(std::remainder(a - b, 2.0 * std::numbers::pi)); }

double squared_mahalanobis(const Eigen::Vector2d& difference, const Eigen::Matrix2d& covariance) {
  return difference.dot(covariance.inverse() * difference);
}

}  // namespace rastro
