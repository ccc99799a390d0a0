// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "rastro/place/location_index.h"

namespace rastro {

struct LocationFilterOptions {
  double stays_new = 0.9;       ///< Probability that a new place is followed by another one.
  double leaves_known = 0.1;    ///< Probability that a known place is followed by a new one.
  double neighbor_sigma = 1.6;  ///< Of the Gaussian over the neighbors of a location, in links.
  int neighbor_reach = 8;       ///< Links.
  /// Locations less likely than this share of what each had if nothing were known keep their probability instead of
  /// giving it to their neighbors, which have about the same: time grows with what is likely, not with the map.
  double least_spread = 1.0;
};

/// How likely the current place is each known location or a new one: a discrete Bayes filter (Labbe and Michaud 2013,
/// section III-C; Angeli et al. 2008). It remembers, so that a single image that looks like another place does not
/// close a loop. Not thread-safe.
class LocationFilter {
 public:
  /// Locations linked to one, directly.
  using Links = std::function<std::span<const std::int64_t>(std::int64_t)>;
  struct Belief {
    double new_place = 1.0;
    std::vector<LocationScore> locations;  ///< Probabilities, ids ascending; with new_place they sum to 1.
    /// The most likely location, the smallest id of equals; null if there is none.
    const LocationScore* best() const;
  };

  explicit LocationFilter(const LocationFilterOptions& options = {}) : options_(options) {}

  /// One step. `scores`: similarity of the current image to every location in working memory, ids ascending. A location
  /// that is new here begins with probability 0, one that is no longer here gives its own to a new place. `links` of
  /// locations that have no score are followed as well.
  const Belief& update(std::span<const LocationScore> scores, const Links& links);
  const Belief& belief() const { return belief_; }

 private:
  std::vector<double> predict(std::span<const LocationScore> scores, const Links& links) const;

  LocationFilterOptions options_;
  Belief belief_;
};

/// How much likelier each location is than one that resembles the image by chance: (s - sigma) / mu for scores s of at
/// least mu + sigma, else 1, with mean and standard deviation of the scores above 0; a new place has mu / sigma + 1
/// (equations 5 and 6 there). Where the scores say nothing, all are 1.
struct RelativeLikelihood {
  double new_place = 1.0;
  std::vector<double> locations;  ///< In the order of the scores.
};
RelativeLikelihood relative_likelihood(std::span<const LocationScore> scores);

}  // namespace rastro
