// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/recognition.h"

#include <algorithm>
#include <map>
#include <optional>

#include "rastro/base/stopwatch.h"
#include "rastro/feature/distance_grid.h"
#include "rastro/math/median.h"
#include "rastro/track/voting.h"

namespace rastro {
namespace {

constexpr int corners_per_chunk = 8;

/// The window's proposals for one corner.
struct Claim {
  std::size_t corner = 0;
  std::vector<Candidate> candidates;
  std::optional<Eigen::Vector2f> pixel;  ///< Position of the first candidate.
};

VotingOptions voting_options(const TrackOptions& options) {
  const bool dual = options.mode == "dual" || options.mode == "priority";
  return {options.max_hamming, options.mode == "priority" ? 2 : 1, dual ? 2 : 1, options.min_votes,
          options.max_travel_px};
}

/// The median motion of the features tracked since each lost track was last observed; nullopt with too few.
std::vector<std::optional<Eigen::Vector2f>> motions_since_lost(std::span<const Association> tracked,
                                                               const TrackStore& store, std::int64_t current) {
  constexpr std::size_t fewest = 8;
  std::map<std::int64_t, std::optional<Eigen::Vector2f>> motion_since;
  const auto motion = [&](std::int64_t frame) -> std::optional<Eigen::Vector2f> {
    const auto [found, added] = motion_since.try_emplace(frame);
    if (!added) return found->second;
    std::vector<float> dx, dy;
    for (const Association& feature : tracked) {
      const Track& track = store[feature.track];
      if (frame >= current || !track.seen_in(frame)) continue;
      const Eigen::Vector2f moved = feature.pixel - track.pixel_in(frame);
      dx.push_back(moved.x());
      dy.push_back(moved.y());
    }
    if (dx.size() >= fewest) found->second = Eigen::Vector2f(upper_median(std::move(dx)), upper_median(std::move(dy)));
    return found->second;
  };
  std::vector<std::optional<Eigen::Vector2f>> motions;
  for (const std::size_t index : store.lost()) motions.push_back(motion(store[index].last_seen));
  return motions;
}

std::vector<Claim> collect_claims(std::span<const Eigen::Vector2f> corners, const Describe& describe,
                                  std::span<const Association> tracked, const TrackStore& store, std::int64_t current,
                                  const TrackOptions& options, TaskPool* pool) {
  std::vector<Claim> claims(corners.size());
  const auto motions = motions_since_lost(tracked, store, current);
  const auto vote = [&](int begin, int end) {
    Voting voting(store, current, voting_options(options));
    voting.expect(motions);
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      claims[i].corner = i;
      if (voting.select_near(corners[i])) claims[i].candidates = voting.candidates_for(describe(corners[i]));
    }
  };
  const int count = static_cast<int>(corners.size());
  if (pool && pool->threads() > 1) {
    pool->for_chunks(0, count, corners_per_chunk, vote);
  } else {
    vote(0, count);
  }
  return claims;
}

/// The claim with most votes first; those without a candidate are removed.
void sort_claims(std::vector<Claim>& claims) {
  std::erase_if(claims, [](const Claim& claim) { return claim.candidates.empty(); });
  std::sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
    const Candidate &first_a = a.candidates.front(), &first_b = b.candidates.front();
    if (first_a.votes != first_b.votes) return first_a.votes > first_b.votes;
    if (first_a.distance != first_b.distance) return first_a.distance < first_b.distance;
    return a.corner < b.corner;
  });
}

/// The tracked features, and each proposed track at the corner with the strongest claim.
std::vector<Association> with_proposals(std::span<const Association> tracked, std::span<const Claim> claims,
                                        const TrackStore& store) {
  std::vector<Association> associations(tracked.begin(), tracked.end());
  std::vector<char> taken(store.size(), 0);
  for (const Claim& claim : claims) {
    const std::size_t track = claim.candidates.front().track;
    if (taken[track] == 0) associations.push_back({track, *claim.pixel, Eigen::Vector2f::Zero()});
    taken[track] = 1;
  }
  return associations;
}

/// Position of the lost track's patch near the corner; the corner itself without alignment; nullopt without a match.
std::optional<Eigen::Vector2f> aligned(const Track& track, std::int64_t current, const Eigen::Vector2f& corner,
                                       const Pyramid& image, const TrackOptions& options) {
  if (!options.align) return corner;
  KltOptions klt;
  klt.iterations = options.flow_iterations;
  klt.epsilon_px = options.flow_epsilon_px;
  klt.min_eigenvalue = options.min_alignment_texture;
  // A feature lost only in this frame was not occluded: it must match as well as a tracked one.
  const bool just_lost = track.last_seen == current - 1;
  klt.max_residual_ratio = just_lost ? options.max_residual_ratio : options.max_alignment_residual;
  const double reach = options.max_alignment_px;
  const KltResult older = track.reference_patch().align(image, corner, reach, klt);
  if (older.followed && older.residual_ratio <= static_cast<float>(options.max_residual_ratio)) return older.pixel;
  const KltResult newer = track.newest_patch().align(image, corner, reach, klt);
  if (!older.followed && !newer.followed) return std::nullopt;
  return older.followed && (!newer.followed || older.residual_ratio <= newer.residual_ratio) ? older.pixel
                                                                                             : newer.pixel;
}

/// Drops the first candidates whose patches do not match and aligns the first that does; those after it are left for
/// later.
void align_claims(std::vector<Claim>& claims, std::span<const Eigen::Vector2f> corners, const TrackStore& store,
                  std::int64_t current, const Pyramid& image, const TrackOptions& options) {
  for (Claim& claim : claims) {
    while (!claim.candidates.empty() && !claim.pixel) {
      claim.pixel = aligned(store[claim.candidates.front().track], current, corners[claim.corner], image, options);
      if (!claim.pixel) claim.candidates.erase(claim.candidates.begin());
    }
  }
}

}  // namespace

std::vector<Recognized> recognize(std::span<const Eigen::Vector2f> corners, const Describe& describe,
                                  std::span<const Association> tracked, const TrackStore& store, std::int64_t current,
                                  const Pyramid& image, int most, const TrackOptions& options, TaskPool* pool,
                                  TrackTimes& times) {
  Stopwatch stopwatch;
  std::vector<Claim> claims = collect_claims(corners, describe, tracked, store, current, options, pool);
  times.match_ms += stopwatch.lap_ms();

  align_claims(claims, corners, store, current, image, options);
  sort_claims(claims);
  const std::vector<Association> associations = with_proposals(tracked, claims, store);
  Validation validation(store, current, associations, options);
  DistanceGrid grid(image.level(0).width(), image.level(0).height(), options.min_distance_px);
  std::vector<Recognized> recognized;
  std::vector<char> taken(store.size(), 0);
  for (const Claim& claim : claims) {
    if (static_cast<int>(recognized.size()) >= most) break;
    for (std::size_t i = 0; i < claim.candidates.size(); ++i) {
      const std::size_t track = claim.candidates[i].track;
      if (taken[track] != 0) continue;
      const auto pixel = i == 0 ? claim.pixel : aligned(store[track], current, corners[claim.corner], image, options);
      if (!pixel || !validation.confirms(track, *pixel)) continue;
      if (grid.add_if_far(pixel->x(), pixel->y())) {
        taken[track] = 1;
        recognized.push_back({claim.corner, track, *pixel});
      }
      break;
    }
  }
  times.validate_ms += stopwatch.lap_ms();
  return recognized;
}

}  // namespace rastro
