// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_pairs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr double covered_steps = 0.6;
constexpr TimeNs longest_step = ns_per_second / 10;
/// Candidates considered on either side of a pose: more are only possible if max_difference spans many poses.
constexpr std::ptrdiff_t most_partners = 8;

struct Candidate {
  double difference_s = 0.0;
  std::size_t reference = 0;
  std::size_t estimate = 0;
};

/// As a double: in published figures its rounding decided between two poses at equal distance.
double rounded_seconds(TimeNs stamp) { return static_cast<double>(static_cast<long double>(stamp) / 1e9L); }

std::vector<Candidate> candidates_of(const Trajectory& reference, const Trajectory& estimate, TimeNs max_difference) {
  std::vector<Candidate> candidates;
  const auto add = [&](Trajectory::const_iterator partner, std::size_t k) {
    if (std::abs(partner->stamp - estimate[k].stamp) > max_difference) return;
    const double difference_s = std::abs(rounded_seconds(partner->stamp) - rounded_seconds(estimate[k].stamp));
    candidates.push_back({difference_s, static_cast<std::size_t>(partner - reference.begin()), k});
  };
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    const auto after = std::lower_bound(reference.begin(), reference.end(), estimate[k].stamp,
                                        [](const StampedPose& pose, TimeNs time) { return pose.stamp < time; });
    const auto first = after - std::min(most_partners, after - reference.begin());
    const auto last = after + std::min(most_partners, reference.end() - after);
    for (auto partner = first; partner != last; ++partner) add(partner, k);
  }
  return candidates;
}

/// Whether reference < estimate order stays the same on both sides with this pair added.
bool keeps_order(const std::map<std::size_t, std::size_t>& taken, const Candidate& candidate) {
  const auto after = taken.lower_bound(candidate.reference);
  if (after != taken.end() && (after->first == candidate.reference || after->second <= candidate.estimate))
    return false;
  return after == taken.begin() || std::prev(after)->second < candidate.estimate;
}

TimeNs median_step(const Trajectory& trajectory) {
  std::vector<TimeNs> steps;
  for (std::size_t k = 1; k < trajectory.size(); ++k) steps.push_back(trajectory[k].stamp - trajectory[k - 1].stamp);
  return upper_median_or(std::move(steps), TimeNs{0});
}

}  // namespace

std::vector<PosePair> pair_by_stamp(const Trajectory& reference, const Trajectory& estimate, TimeNs max_difference) {
  std::vector<Candidate> candidates = candidates_of(reference, estimate, max_difference);
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.difference_s, a.reference, a.estimate) < std::tie(b.difference_s, b.reference, b.estimate);
  });
  std::map<std::size_t, std::size_t> taken;  // estimate by reference
  for (const Candidate& candidate : candidates)
    if (keeps_order(taken, candidate)) taken.emplace(candidate.reference, candidate.estimate);
  std::vector<PosePair> pairs;
  for (const auto& [r, e] : taken) pairs.push_back({r, e});
  return pairs;
}

std::vector<PosePair> pair_by_index(const Trajectory& reference, const Trajectory& estimate) {
  std::vector<PosePair> pairs;
  for (std::size_t k = 0; k < std::min(reference.size(), estimate.size()); ++k) pairs.push_back({k, k});
  return pairs;
}

double coverage_of(const Trajectory& reference, const Trajectory& estimate, const std::vector<PosePair>& pairs,
                   bool by_index) {
  if (reference.empty() || pairs.empty()) return 0.0;
  if (by_index) return static_cast<double>(pairs.size()) / static_cast<double>(reference.size());
  const TimeNs step = std::max(median_step(reference), std::min(median_step(estimate), longest_step));
  const double reach = covered_steps * static_cast<double>(step);
  std::size_t covered = 0;
  std::size_t next = 0;  // the first matched pose that is not before the current one
  for (std::size_t k = 0; k < reference.size(); ++k) {
    const auto distance = [&](std::size_t pair) {
      return std::abs(static_cast<double>(reference[pairs[pair].reference].stamp - reference[k].stamp));
    };
    while (next < pairs.size() && pairs[next].reference < k) ++next;
    const bool by_next = next < pairs.size() && distance(next) <= reach;
    covered += by_next || (next > 0 && distance(next - 1) <= reach) ? 1 : 0;
  }
  return static_cast<double>(covered) / static_cast<double>(reference.size());
}

}  // namespace rastro
