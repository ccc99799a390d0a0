// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/location_filter.h"

#include <algorithm>
#include <cmath>

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
  const std::map<std::int64_t, double> predicted = predict(scores, links);
  const RelativeLikelihood likelihood = relative_likelihood(scores);
  Belief updated;
  double known = 0.0;
  for (const auto& [location, probability] : predicted) known += probability;
  updated.new_place = likelihood.new_place * (1.0 - known);
  double sum = updated.new_place;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const double probability = likelihood.locations[i] * predicted.at(scores[i].location);
    updated.locations.push_back({scores[i].location, probability});
    sum += probability;
  }
  updated.new_place /= sum;
  for (LocationScore& each : updated.locations) each.score /= sum;
  belief_ = std::move(updated);
  return belief_;
}

/// The transition model: what is not known is a new place.
std::map<std::int64_t, double> LocationFilter::predict(std::span<const LocationScore> scores,
                                                       const Links& links) const {
  std::map<std::int64_t, double> predicted;
  for (const LocationScore& each : scores) predicted[each.location] = 0.0;
  double gone = belief_.new_place;
  for (const LocationScore& each : belief_.locations) {
    if (!predicted.contains(each.location))
      gone += each.score;
    else
      spread(each.location, (1.0 - options_.leaves_known) * each.score, links, predicted);
  }
  if (predicted.empty()) return predicted;
  const double found_again = (1.0 - options_.stays_new) * gone / static_cast<double>(predicted.size());
  for (auto& [location, probability] : predicted) probability += found_again;
  return predicted;
}

/// Over the location and its neighbors in working memory, by a Gaussian of the number of links between.
void LocationFilter::spread(std::int64_t from, double probability, const Links& links,
                            std::map<std::int64_t, double>& predicted) const {
  std::map<std::int64_t, int> links_to{{from, 0}};
  std::vector<std::int64_t> edge{from};
  for (int reached = 1; reached <= options_.neighbor_reach; ++reached) {
    std::vector<std::int64_t> next;
    for (const std::int64_t location : edge) {
      for (const std::int64_t neighbor : links(location))
        if (links_to.emplace(neighbor, reached).second) next.push_back(neighbor);
    }
    edge = std::move(next);
  }
  std::erase_if(links_to, [&](const auto& each) { return !predicted.contains(each.first); });
  const auto weight = [&](int steps) {
    const double sigmas = steps / options_.neighbor_sigma;
    return std::exp(-0.5 * sigmas * sigmas);
  };
  double sum = 0.0;
  for (const auto& [location, steps] : links_to) sum += weight(steps);
  for (const auto& [location, steps] : links_to) predicted[location] += probability * weight(steps) / sum;
}

}  // namespace rastro
