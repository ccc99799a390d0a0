// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/recognition.h"

#include <algorithm>

#include "rastro/feature/distance_grid.h"
#include "rastro/track/stopwatch.h"
#include "rastro/track/voting.h"

namespace rastro {
namespace {

constexpr int corners_per_chunk = 8;

/// What the window proposes for one corner.
struct Claim {
  std::size_t corner = 0;
  std::vector<Candidate> candidates;
};

VotingOptions voting_options(const TrackOptions& options) {
  const bool dual = options.mode == "dual" || options.mode == "priority";
  return {options.max_hamming, options.mode == "priority" ? 2 : 1, dual ? 2 : 1, options.min_votes};
}

/// Claims with at least one candidate, the one with most votes first.
std::vector<Claim> collect_claims(std::span<const NewCorner> corners, const TrackStore& store, std::int64_t current,
                                  const TrackOptions& options, TaskPool* pool) {
  std::vector<Claim> claims(corners.size());
  const auto vote = [&](int begin, int end) {
    Voting voting(store, current, voting_options(options));
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      claims[i] = {i, voting.candidates_for(corners[i].views)};
    }
  };
  const int count = static_cast<int>(corners.size());
  if (pool && pool->threads() > 1) {
    pool->for_chunks(0, count, corners_per_chunk, vote);
  } else {
    vote(0, count);
  }
  std::erase_if(claims, [](const Claim& claim) { return claim.candidates.empty(); });
  std::sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
    const Candidate &first_a = a.candidates.front(), &first_b = b.candidates.front();
    if (first_a.votes != first_b.votes) return first_a.votes > first_b.votes;
    if (first_a.distance != first_b.distance) return first_a.distance < first_b.distance;
    return a.corner < b.corner;
  });
  return claims;
}

/// The tracked features, and each proposed track at the corner that claims it most strongly.
std::vector<Association> with_proposals(std::span<const Association> tracked, std::span<const Claim> claims,
                                        std::span<const NewCorner> corners) {
  std::vector<Association> associations(tracked.begin(), tracked.end());
  for (const Claim& claim : claims) {
    const std::size_t track = claim.candidates.front().track;
    const bool taken = std::any_of(associations.begin() + static_cast<std::ptrdiff_t>(tracked.size()), associations.end(),
                                   [=](const Association& a) { return a.track == track; });
    if (!taken) associations.push_back({track, corners[claim.corner].pixel});
  }
  return associations;
}

}  // namespace

std::vector<Recognised> recognise(std::span<const NewCorner> corners, std::span<const Association> tracked, const TrackStore& store,
                                  std::int64_t current, int most, const TrackOptions& options, int width, int height, TaskPool* pool,
                                  TrackTimes& times) {
  Stopwatch stopwatch;
  const std::vector<Claim> claims = collect_claims(corners, store, current, options, pool);
  times.match_ms += stopwatch.lap_ms();

  const std::vector<Association> associations = with_proposals(tracked, claims, corners);
  Validation validation(store, current, associations, options);
  DistanceGrid grid(width, height, options.min_distance_px);
  std::vector<Recognised> recognised;
  for (const Claim& claim : claims) {
    if (static_cast<int>(recognised.size()) >= most) break;
    const Eigen::Vector2f& pixel = corners[claim.corner].pixel;
    for (const Candidate& candidate : claim.candidates) {
      const bool taken = std::any_of(recognised.begin(), recognised.end(), [&](const Recognised& r) { return r.track == candidate.track; });
      if (taken || !validation.confirms(candidate.track, pixel)) continue;
      if (grid.add_if_far(pixel.x(), pixel.y())) recognised.push_back({claim.corner, candidate.track});
      break;
    }
  }
  times.validate_ms += stopwatch.lap_ms();
  return recognised;
}

}  // namespace rastro
