// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/association.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

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

  Association operator()(const Sighting& sighting) const {
    return sighting.sensor_id >= 0 ? by_name(sighting) : by_distance(sighting);
  }

 private:
  double distance(const Sighting& sighting, std::size_t landmark) const {
    const auto& expected = expected_[landmark];
    return squared_mahalanobis(sighting.in_body - expected.in_body, expected.covariance + sighting.covariance);
  }

  bool alike(const Sighting& sighting, const LandmarkRecord& record) const {
    if (sighting.kind != record.kind || record.sensor_id >= 0) return false;
    if (sighting.kind != LandmarkKind::corner) return true;
    const double off = angle_between(sighting.direction + heading_, record.direction);
    return off <= options_.max_direction_deg * std::numbers::pi / 180.0;
  }

  Association by_name(const Sighting& sighting) const {
    for (std::size_t i = 0; i < records_.size(); ++i) {
      if (records_[i].sensor_id != sighting.sensor_id) continue;
      const double found = distance(sighting, i);
      return {found <= options_.named_gate ? kind_of(records_[i]) : Association::Kind::contradicting, i, found};
    }
    return {};
  }

  static Association::Kind kind_of(const LandmarkRecord& record) {
    return record.is_candidate() ? Association::Kind::candidate : Association::Kind::landmark;
  }

  Association by_distance(const Sighting& sighting) const {
    const Association in_map = nearest(sighting, false);
    return in_map.kind == Association::Kind::fresh ? nearest(sighting, true) : in_map;
  }

  Association nearest(const Sighting& sighting, bool candidates) const {
    Association best{Association::Kind::fresh, 0, nothing_near};
    double second = nothing_near;
    for (std::size_t i = 0; i < records_.size(); ++i) {
      if (records_[i].is_candidate() != candidates || !alike(sighting, records_[i])) continue;
      const double found = distance(sighting, i);
      if (found < best.distance) {
        second = best.distance;
        best = {Association::Kind::fresh, i, found};
      } else if (found < second) {
        second = found;
      }
    }
    if (best.distance > options_.new_gate) return best;
    const bool clear = second > options_.gate || second - best.distance >= options_.ambiguity;
    best.kind = clear ? kind_of(records_[best.landmark]) : Association::Kind::ambiguous;
    if (best.distance > options_.gate) {
      best.kind = candidates ? Association::Kind::ambiguous : Association::Kind::contradicting;
    }
    return best;
  }

  std::span<const LandmarkRecord> records_;
  const EkfOptions& options_;
  double heading_;
  std::vector<EkfFilter::Expected> expected_;
};

/// Where several sightings claim one landmark, the nearest has it.
void settle_claims(std::vector<Association>& associations, std::size_t landmarks) {
  std::vector<std::optional<std::size_t>> claimed(landmarks);
  for (std::size_t i = 0; i < associations.size(); ++i) {
    const Association::Kind kind = associations[i].kind;
    if (kind != Association::Kind::landmark && kind != Association::Kind::candidate) continue;
    auto& holder = claimed[associations[i].landmark];
    std::size_t loser = i;
    if (!holder) {
      holder = i;
      continue;
    }
    if (associations[i].distance < associations[*holder].distance) std::swap(loser, *holder);
    associations[loser].kind = Association::Kind::ambiguous;
  }
}

bool is_known(const Association& association) { return association.kind == Association::Kind::landmark; }

/// Whether two sightings are as far apart as the landmarks they are taken for.
bool agree(const EkfFilter& filter, const Sighting& a, const Sighting& b, std::size_t landmark_a,
           std::size_t landmark_b, double gate) {
  const Eigen::Vector2d between = a.in_body - b.in_body;
  const double distance = between.norm();
  if (!(distance > 0.0)) return false;
  const auto in_map = filter.separation(landmark_a, landmark_b);
  const double variance = between.dot((a.covariance + b.covariance) * between) / (distance * distance);
  const double off = distance - in_map.distance;
  return off * off <= gate * (variance + in_map.variance);
}

/// Where the body is uncertain one landmark in the gate says little: some other must be where it should be, too.
void drop_lonely(const EkfFilter& filter, std::span<const Sighting> sightings, const EkfOptions& options,
                 std::vector<Association>& associations) {
  const std::vector<Association> before = associations;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!is_known(before[i]) || sightings[i].sensor_id >= 0) continue;
    const double doubt = filter.expected(before[i].landmark).covariance.trace();
    if (doubt <= options.unsure_m * options.unsure_m) continue;
    int companions = 0;
    for (std::size_t j = 0; j < before.size(); ++j) {
      const bool other =
          j != i && is_known(before[j]) &&
          agree(filter, sightings[i], sightings[j], before[i].landmark, before[j].landmark, options.gate);
      companions += other ? 1 : 0;
    }
    if (companions < options.companions) associations[i].kind = Association::Kind::ambiguous;
  }
}

}  // namespace

std::vector<Association> associate(const EkfFilter& filter, std::span<const LandmarkRecord> records,
                                   std::span<const Sighting> sightings, const EkfOptions& options) {
  const Associator associator(filter, records, options);
  std::vector<Association> result;
  result.reserve(sightings.size());
  for (const Sighting& sighting : sightings) result.push_back(associator(sighting));
  settle_claims(result, records.size());
  drop_lonely(filter, sightings, options, result);
  return result;
}

double angle_between(double a, double b) { return std::abs(std::remainder(a - b, 2.0 * std::numbers::pi)); }

double squared_mahalanobis(const Eigen::Vector2d& difference, const Eigen::Matrix2d& covariance) {
  return difference.dot(covariance.inverse() * difference);
}

}  // namespace rastro
