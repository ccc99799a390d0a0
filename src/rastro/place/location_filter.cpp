// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/location_filter.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>
#include <utility>

namespace rastro {

RelativeLikelihood relative_likelihood(std::span<const LocationScore> scores) {
  RelativeLikelihood likelihood;
  likelihood.locations.assign(scores.size(), 1.0);
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const LocationScore& each : scores) {
    if (!(each.score > 0.0)) continue;
    sum += each.score;
    squares += each.score * each.score;
    count += 1.0;
  }
  if (count < 2.0) return likelihood;
  const double mean = sum / count, sigma = std::sqrt(std::max(0.0, squares / count - mean * mean));
  constexpr double least_share = 1e-9;  // of the mean: rounding
  if (!(sigma > least_share * mean)) return likelihood;
  likelihood.new_place = mean / sigma + 1.0;
  for (std::size_t i = 0; i < scores.size(); ++i)
    if (scores[i].score >= mean + sigma) likelihood.locations[i] = (scores[i].score - sigma) / mean;
  return likelihood;
}

const LocationScore* LocationFilter::Belief::best() const {
  const auto best = std::max_element(locations.begin(), locations.end(),
                                     [](const LocationScore& a, const LocationScore& b) { return a.score < b.score; });
  return best == locations.end() ? nullptr : &*best;
}

const LocationFilter::Belief& LocationFilter::update(std::span<const LocationScore> scores, const Links& links) {
  const std::vector<double> predicted = predict(scores, links);
  const RelativeLikelihood likelihood = relative_likelihood(scores);
  Belief updated;
  double known = 0.0;
  for (const double probability : predicted) known += probability;
  updated.new_place = likelihood.new_place * (1.0 - known);
  double sum = updated.new_place;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const double probability = likelihood.locations[i] * predicted[i];
    updated.locations.push_back({scores[i].location, probability});
    sum += probability;
  }
  updated.new_place /= sum;
  for (LocationScore& each : updated.locations) each.score /= sum;
  belief_ = std::move(updated);
  return belief_;
}

namespace {

/// Gives the probability of a location to it and its neighbors in working memory, by a Gaussian of the number of links
/// between.
class Spread {
 public:
  Spread(std::span<const LocationScore> scores, const LocationFilterOptions& options,
         const LocationFilter::Links& links)
      : links_(links), scores_(scores), predicted_(scores.size(), 0.0) {
    for (int steps = 0; steps <= options.neighbor_reach; ++steps) {
      const double sigmas = steps / options.neighbor_sigma;
      weights_.push_back(std::exp(-0.5 * sigmas * sigmas));
    }
  }

  /// Of a location in the scores; nullopt: it has left.
  std::optional<std::size_t> place_of(std::int64_t location) const {
    const auto at = std::lower_bound(scores_.begin(), scores_.end(), location,
                                     [](const LocationScore& score, std::int64_t id) { return score.location < id; });
    if (at == scores_.end() || at->location != location) return std::nullopt;
    return static_cast<std::size_t>(at - scores_.begin());
  }

  void keep(std::size_t place, double probability) { predicted_[place] += probability; }

  void add(std::int64_t from, double probability) {
    reached_.assign({{from, 0}});
    seen_.clear();
    seen_.insert(from);
    for (std::size_t next = 0; next < reached_.size(); ++next) {
      const auto [location, steps] = reached_[next];
      if (steps + 1 == weights_.size()) break;
      for (const std::int64_t neighbor : links_(location))
        if (seen_.insert(neighbor).second) reached_.push_back({neighbor, steps + 1});
    }
    share(probability);
  }

  std::vector<double>& predicted() { return predicted_; }

 private:
  struct Reached {
    std::int64_t location;
    std::size_t steps;
  };

  void share(double probability) {
    targets_.clear();
    double sum = 0.0;
    for (const Reached& each : reached_) {
      const auto place = place_of(each.location);
      if (!place) continue;
      targets_.emplace_back(*place, weights_[each.steps]);
      sum += weights_[each.steps];
    }
    for (const auto& [place, weight] : targets_) predicted_[place] += probability * weight / sum;
  }

  const LocationFilter::Links& links_;
  std::span<const LocationScore> scores_;
  std::vector<double> weights_, predicted_;
  std::vector<Reached> reached_;
  std::unordered_set<std::int64_t> seen_;
  std::vector<std::pair<std::size_t, double>> targets_;
};

}  // namespace

/// The transition model: what is not known is a new place.
std::vector<double> LocationFilter::predict(std::span<const LocationScore> scores, const Links& links) const {
  Spread spread(scores, options_, links);
  const double least = options_.least_spread / static_cast<double>(belief_.locations.size() + 1);
  double gone = belief_.new_place;
  for (const LocationScore& each : belief_.locations) {
    const double stays = (1.0 - options_.leaves_known) * each.score;
    const auto place = spread.place_of(each.location);
    if (!place)
      gone += each.score;
    else if (each.score < least)
      spread.keep(*place, stays);
    else
      spread.add(each.location, stays);
  }
  std::vector<double> predicted = std::move(spread.predicted());
  const double found_again =
      (1.0 - options_.stays_new) * gone / static_cast<double>(std::max<std::size_t>(1, predicted.size()));
  for (double& probability : predicted) probability += found_again;
  return predicted;
}

}  // namespace rastro
