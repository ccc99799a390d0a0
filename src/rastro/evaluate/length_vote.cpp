// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_vote.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace rastro {
namespace {

using Eigen::Vector3d;

constexpr double vote_width_m = 0.006;  ///< Of one candidate: about the error of keyframe poses.
constexpr double agree_widths = 3.5;    ///< Candidates within this many widths of the chosen offset are selected.
constexpr double height_step_m = 0.005;

/// Offset of a candidate from the rough point, along the search direction.
double offset_of(const LengthFeature& feature, const LengthCandidate& candidate, double height_m) {
  const Vector3d axis = feature.is_edge ? feature.inwards : candidate.direction;
  return axis.dot(candidate.point + height_m * candidate.lever - feature.spot);
}

double vote(double distance_m, double width_m) { return std::exp(-0.5 * std::pow(distance_m / width_m, 2)); }

/// Maximum of the views' votes: the offset from the rough point with the most votes, and their number.
struct VotedOffset {
  double offset_m = 0.0, votes = 0.0;
  double height_m = 0.0;  ///< Height of the face, for candidates with a lever.
};

/// The offset with the most votes, near the rough point rather than far from it. A view has one vote per offset, that
/// of its best candidate there.
VotedOffset most_voted_at(double height_m, const std::vector<std::vector<LengthCandidate>>& views,
                          const LengthFeature& feature, const LengthPrior& prior) {
  std::vector<std::vector<std::pair<double, double>>> ballots;  // offsets with scores
  for (const auto& view : views) {
    ballots.emplace_back();
    for (const LengthCandidate& one : view) ballots.back().emplace_back(offset_of(feature, one, height_m), one.score);
  }
  VotedOffset best;
  for (const auto& proposer : ballots) {
    for (const auto& [offset, ignored] : proposer) {
      double votes = 0.0;
      for (const auto& voter : ballots) {
        double strongest = 0.0;
        for (const auto& [other, score] : voter)
          strongest = std::max(strongest, score * vote(other - offset, vote_width_m));
        votes += strongest;
      }
      votes *= vote(offset, LengthPrior::spot_sigma_share * prior.radius_m);
      if (prior.height_sigma_m > 0.0) votes *= vote(height_m, prior.height_sigma_m);
      if (votes > best.votes) best = {offset, votes, height_m};
    }
  }
  return best;
}

/// The same over all possible heights of the face, without depth.
VotedOffset most_voted(const std::vector<std::vector<LengthCandidate>>& views, const LengthFeature& feature,
                       const LengthPrior& prior) {
  VotedOffset best = most_voted_at(0.0, views, feature, prior);
  const auto steps = static_cast<int>(std::lround(2.0 * prior.height_sigma_m / height_step_m));
  for (int step = -steps; step <= steps; ++step) {
    const VotedOffset other = most_voted_at(step * height_step_m, views, feature, prior);
    if (other.votes > best.votes) best = other;
  }
  return best;
}

/// Selects the candidate of a view that matches the offset; nullopt if it has none.
std::optional<LengthCandidate> taken_at(std::vector<LengthCandidate>& candidates, const LengthFeature& feature,
                                        const VotedOffset& voted) {
  auto best = candidates.end();
  double most = 0.0;
  for (auto one = candidates.begin(); one != candidates.end(); ++one) {
    const double distance = offset_of(feature, *one, voted.height_m) - voted.offset_m;
    const double score = one->score * vote(distance, vote_width_m);
    if (std::abs(distance) < agree_widths * vote_width_m && score > most) most = score, best = one;
  }
  if (best == candidates.end()) return std::nullopt;
  const LengthCandidate taken = *best;
  candidates.erase(best);
  return taken;
}

std::vector<std::vector<LengthCandidate>> candidates_for(const std::vector<LengthFinding>& findings,
                                                         std::size_t which) {
  std::vector<std::vector<LengthCandidate>> views;
  for (const LengthFinding& finding : findings) views.push_back(finding.candidates[which]);
  return views;
}

}  // namespace

FoundFeature agreed_feature(const std::vector<LengthFinding>& findings, std::size_t which, const LengthFeature& feature,
                            const LengthPrior& prior) {
  FoundFeature found;
  std::vector<std::vector<LengthCandidate>> views = candidates_for(findings, which);
  const VotedOffset chosen = most_voted(views, feature, prior);
  if (!(chosen.votes > 0.0)) return found;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto taken = taken_at(views[i], feature, chosen);
    if (!taken) continue;
    found.observations.emplace_back(i, *taken);
    found.observations.back().second.point += chosen.height_m * taken->lever;
  }
  const VotedOffset rival = most_voted(views, feature, prior);
  found.rivalry = rival.votes / chosen.votes;
  found.height_m = chosen.height_m;
  // Votes are no probabilities: an offset with half of them is hardly ever the right one.
  const double odds = std::pow(found.rivalry, 4), share = odds / (1.0 + odds);
  found.wrong_position_variance = share * (1.0 - share) * std::pow(rival.offset_m - chosen.offset_m, 2);
  for (auto& [finding, one] : found.observations) {
    if (one.direction.dot(found.observations.front().second.direction) < 0.0) one.direction = -one.direction;
    found.point += one.point / static_cast<double>(found.observations.size());
    found.direction += one.direction;
  }
  found.direction.normalize();
  return found;
}

FoundFeature crossing_of(const FoundFeature& one, const FoundFeature& other) {
  FoundFeature corner;
  corner.wrong_position_variance = one.wrong_position_variance + other.wrong_position_variance;
  corner.rivalry = std::max(one.rivalry, other.rivalry);
  corner.height_m = one.height_m;  // as the levers of its points
  for (const auto& [finding, first] : one.observations) {
    for (const auto& [same, second] : other.observations) {
      if (finding != same) continue;
      const double cosine = first.direction.dot(second.direction), sine_squared = 1.0 - cosine * cosine;
      if (sine_squared < 0.05) continue;
      const Vector3d between = second.point - first.point;
      const double along = (between.dot(first.direction) - cosine * between.dot(second.direction)) / sine_squared;
      LengthCandidate point = first;
      point.point = first.point + along * first.direction;
      point.covariance = first.covariance + second.covariance;
      point.pixels = {first.pixels[0], second.pixels[0]};
      corner.observations.emplace_back(finding, point);
      corner.point += point.point;
    }
  }
  if (!corner.observations.empty()) corner.point /= static_cast<double>(corner.observations.size());
  return corner;
}

}  // namespace rastro
