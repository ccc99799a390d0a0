// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/joint_compatibility.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include "rastro/slam/ekf/association.h"

namespace rastro {
namespace {

constexpr std::size_t most_pairs = 60;  // of them all sets are searched

/// The value that 99 % of squared Mahalanobis distances are below; Wilson and Hilferty's approximation.
double compatible_distance(std::size_t pairs) {
  constexpr double quantile = 2.326;
  const double share = 2.0 / (9.0 * 2.0 * static_cast<double>(pairs));
  return 2.0 * static_cast<double>(pairs) * std::pow(1.0 - share + quantile * std::sqrt(share), 3.0);
}

/// Pairs whose landmarks would be at the same position, and how far they are from it, jointly.
struct Offsets {
  std::vector<LandmarkPair> pairs;
  Eigen::VectorXd mean;        ///< Two entries a pair, meters.
  Eigen::MatrixXd covariance;  ///< Of mean.

  static Eigen::Index row_of(std::size_t pair) { return 2 * static_cast<Eigen::Index>(pair); }
  double distance(std::size_t pair) const {
    const Eigen::Index row = row_of(pair);
    return squared_mahalanobis(mean.segment<2>(row), covariance.block<2, 2>(row, row));
  }
  /// Given that the landmarks of this pair are one.
  void condition(std::size_t pair) {
    const Eigen::Index row = row_of(pair);
    const Eigen::MatrixXd cross = covariance.middleCols<2>(row);
    const Eigen::MatrixXd gain = cross * covariance.block<2, 2>(row, row).inverse();
    mean -= gain * Eigen::Vector2d(mean.segment<2>(row));
    covariance -= gain * cross.transpose();
  }
};

struct PairSet {
  std::vector<std::size_t> pairs;  ///< Ascending.
  double distance = 0.0;           ///< Squared Mahalanobis, joint.

  bool better_than(const PairSet& other) const {
    return pairs.size() != other.pairs.size() ? pairs.size() > other.pairs.size() : distance < other.distance;
  }
};

bool alike(const LandmarkRecord& a, const LandmarkRecord& b, const EkfOptions& options) {
  if (a.kind != b.kind || a.sensor_id >= 0 || b.sensor_id >= 0) return false;
  if (a.kind != LandmarkKind::corner) return true;
  return angle_between(a.direction, b.direction) <= options.max_direction_deg * std::numbers::pi / 180.0;
}

Eigen::Matrix2d noise_of(const EkfOptions& options) {
  return options.corner_error_m * options.corner_error_m * Eigen::Matrix2d::Identity();
}

Eigen::Matrix2d covariance_between(const EkfFilter& filter, const LandmarkPair& a, const LandmarkPair& b) {
  return filter.landmark_covariance(a.recent, b.recent) - filter.landmark_covariance(a.recent, b.known) -
         filter.landmark_covariance(a.known, b.recent) + filter.landmark_covariance(a.known, b.known);
}

class PlaceMatcher {
 public:
  PlaceMatcher(const EkfFilter& filter, std::span<const LandmarkRecord> records, const EkfOptions& options)
      : filter_(filter), records_(records), options_(options) {
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (records[i].sensor_id >= 0) continue;
      const bool unsure = is_unsure(filter.expected(i), records[i].noise_m2, options);
      if (unsure && !records[i].is_candidate()) known_.push_back(i);
      if (!unsure && records[i].observations >= options.observations) recent_.push_back(i);
    }
  }

  std::vector<LandmarkPair> recognized() {
    constexpr std::size_t lead = 2;
    const std::size_t needed = static_cast<std::size_t>(options_.companions) + 1;
    if (known_.size() < needed || recent_.size() < needed) return {};
    collect_pairs();
    std::vector<PairSet> sets;
    for (std::size_t seed = 0; seed < offsets_.pairs.size(); ++seed) sets.push_back(grown(seed));
    const auto best =
        std::min_element(sets.begin(), sets.end(), [](const PairSet& a, const PairSet& b) { return a.better_than(b); });
    if (best == sets.end() || best->pairs.size() < needed || 2 * best->pairs.size() < recent_near_known()) return {};
    for (const PairSet& set : sets)
      if (contradicts(*best, set) && set.pairs.size() + lead > best->pairs.size()) return {};
    std::vector<LandmarkPair> result;
    for (const std::size_t pair : extended(best->pairs)) result.push_back(offsets_.pairs[pair]);
    return result;
  }

 private:
  void collect_pairs() {
    std::vector<std::pair<double, LandmarkPair>> near;
    for (const std::size_t recent : recent_) {
      for (const std::size_t known : known_) {
        if (!alike(records_[recent], records_[known], options_)) continue;
        const LandmarkPair pair{recent, known};
        const double distance = squared_mahalanobis(filter_.landmark(recent) - filter_.landmark(known),
                                                    covariance_between(filter_, pair, pair) + noise_of(options_));
        if (distance <= options_.gate) near.emplace_back(distance, pair);
      }
    }
    std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    near.resize(std::min(near.size(), most_pairs));
    for (const auto& [distance, pair] : near) offsets_.pairs.push_back(pair);
    fill_offsets();
  }

  void fill_offsets() {
    const std::vector<LandmarkPair>& pairs = offsets_.pairs;
    const Eigen::Index size = Offsets::row_of(pairs.size());
    offsets_.mean.resize(size);
    offsets_.covariance.resize(size, size);
    for (std::size_t a = 0; a < pairs.size(); ++a) {
      const Eigen::Index row = Offsets::row_of(a);
      offsets_.mean.segment<2>(row) = filter_.landmark(pairs[a].recent) - filter_.landmark(pairs[a].known);
      for (std::size_t b = 0; b < pairs.size(); ++b)
        offsets_.covariance.block<2, 2>(row, Offsets::row_of(b)) = covariance_between(filter_, pairs[a], pairs[b]);
      offsets_.covariance.block<2, 2>(row, row) += noise_of(options_);
    }
  }

  /// From one pair on, each time with the nearest other one.
  PairSet grown(std::size_t seed) const {
    Offsets left = offsets_;
    PairSet set;
    for (std::optional<std::size_t> next = seed; next;) {
      set.distance += left.distance(*next);
      set.pairs.push_back(*next);
      left.condition(*next);
      const double room = compatible_distance(set.pairs.size() + 1) - set.distance;
      const auto is_usable = [&](std::size_t pair) { return is_free(pair, set.pairs); };
      next = nearest(left, std::min(options_.gate, room), is_usable);
    }
    std::sort(set.pairs.begin(), set.pairs.end());
    return set;
  }

  /// The place is recognized, and its pairs correct the drift: the others are associated one by one then, as
  /// observations are. Their landmarks would stay in the map twice.
  std::vector<std::size_t> extended(std::vector<std::size_t> pairs) const {
    Offsets left = offsets_;
    for (const std::size_t pair : pairs) left.condition(pair);
    const auto is_usable = [&](std::size_t pair) { return is_free(pair, pairs) && is_clear(pair, left, pairs); };
    while (const std::optional<std::size_t> next = nearest(left, options_.gate, is_usable)) {
      pairs.push_back(*next);
      left.condition(*next);
    }
    return pairs;
  }

  template <typename IsUsable>
  static std::optional<std::size_t> nearest(const Offsets& left, double least, IsUsable is_usable) {
    std::optional<std::size_t> best;
    for (std::size_t pair = 0; pair < left.pairs.size(); ++pair) {
      const double distance = is_usable(pair) ? left.distance(pair) : least;
      if (!(distance < least)) continue;
      least = distance;
      best = pair;
    }
    return best;
  }

  /// Neither landmark has another partner that is nearly as likely.
  bool is_clear(std::size_t pair, const Offsets& left, std::span<const std::size_t> taken) const {
    const double least = std::min(options_.gate, left.distance(pair) + options_.ambiguity);
    for (std::size_t other = 0; other < left.pairs.size(); ++other)
      if (other != pair && overlap(pair, other) && is_free(other, taken) && left.distance(other) < least) return false;
    return true;
  }

  bool is_free(std::size_t pair, std::span<const std::size_t> taken) const {
    return std::none_of(taken.begin(), taken.end(), [&](std::size_t other) { return overlap(pair, other); });
  }

  bool overlap(std::size_t a, std::size_t b) const {
    return offsets_.pairs[a].recent == offsets_.pairs[b].recent || offsets_.pairs[a].known == offsets_.pairs[b].known;
  }

  /// A set of another place: one common pair only leaves the heading open.
  static bool contradicts(const PairSet& a, const PairSet& b) {
    std::vector<std::size_t> common;
    std::set_intersection(a.pairs.begin(), a.pairs.end(), b.pairs.begin(), b.pairs.end(), std::back_inserter(common));
    return common.size() < 2;
  }

  /// How many recent landmarks could be ones that are mapped.
  std::size_t recent_near_known() const {
    std::vector<std::size_t> recent;
    for (const LandmarkPair& pair : offsets_.pairs) recent.push_back(pair.recent);
    std::sort(recent.begin(), recent.end());
    return static_cast<std::size_t>(std::unique(recent.begin(), recent.end()) - recent.begin());
  }

  const EkfFilter& filter_;
  std::span<const LandmarkRecord> records_;
  const EkfOptions& options_;
  std::vector<std::size_t> recent_, known_;
  Offsets offsets_;
};

}  // namespace

bool is_unsure(const EkfFilter::Expected& expected, double noise_m2, const EkfOptions& options) {
  return expected.covariance.trace() > std::max(options.unsure_m * options.unsure_m, 2.0 * noise_m2);
}

std::vector<LandmarkPair> recognized_pairs(const EkfFilter& filter, std::span<const LandmarkRecord> records,
                                           const EkfOptions& options) {
  return PlaceMatcher(filter, records, options).recognized();
}

}  // namespace rastro
