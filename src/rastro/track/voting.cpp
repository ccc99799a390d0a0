// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/voting.h"

#include <algorithm>
#include <limits>

#include "rastro/feature/hamming.h"

namespace rastro {
namespace {

constexpr int no_distance = std::numeric_limits<int>::max();

/// distances[i] = least Hamming distance of any view to candidates[i].
void nearest_of_views(std::span<const Descriptor> views, std::span<const Descriptor> candidates,
                      std::vector<std::uint16_t>& scratch, std::vector<std::uint16_t>& distances) {
  distances.resize(candidates.size());
  hamming_distances(views[0], candidates, distances);
  for (std::size_t view = 1; view < views.size(); ++view) {
    scratch.resize(candidates.size());
    hamming_distances(views[view], candidates, scratch);
    for (std::size_t i = 0; i < candidates.size(); ++i) distances[i] = std::min(distances[i], scratch[i]);
  }
}

}  // namespace

Voting::Voting(const TrackStore& store, std::int64_t current, const VotingOptions& options)
    : store_(store), oldest_(current - store.window()), options_(options) {
  for (const std::size_t index : store.lost()) {
    const Track& track = store[index];
    lost_.push_back({track.last_descriptor(), track.pixel_in(track.last_seen), track.descriptor_spread});
    near_.push_back(near_.size());
    near_descriptors_.push_back(track.last_descriptor());
  }
}

void Voting::expect(const std::vector<std::optional<Eigen::Vector2f>>& motions) {
  RASTRO_CHECK(motions.size() == lost_.size(), "one motion per lost track");
  constexpr float anywhere = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < lost_.size(); ++i) {
    const Eigen::Vector2f last = motions[i] ? lost_[i].last_pixel : Eigen::Vector2f(anywhere, anywhere);
    const Eigen::Vector2f moved = motions[i] ? Eigen::Vector2f(last + *motions[i]) : last;
    x_.push_back(last.x());
    y_.push_back(last.y());
    moved_x_.push_back(moved.x());
    moved_y_.push_back(moved.y());
  }
}

bool Voting::select_near(const Eigen::Vector2f& pixel) {
  if (options_.max_travel_px <= 0.0 || x_.empty()) return !lost_.empty();
  const auto limit = static_cast<float>(options_.max_travel_px * options_.max_travel_px);
  const std::size_t count = lost_.size();
  is_near_.resize(count);
  const float *x = x_.data(), *y = y_.data(), *moved_x = moved_x_.data(), *moved_y = moved_y_.data();
  std::int32_t* near = is_near_.data();
  const float px = pixel.x(), py = pixel.y();
  // An object in front may have most features: then zero motion is the better guess. Positions that are not finite are
  // near to all.
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = px - x[i], dy = py - y[i], moved_dx = px - moved_x[i], moved_dy = py - moved_y[i];
    const bool far = (dx * dx + dy * dy > limit) & (moved_dx * moved_dx + moved_dy * moved_dy > limit);
    near[i] = far ? 0 : 1;
  }
  near_.clear();
  near_descriptors_.clear();
  for (std::size_t i = 0; i < lost_.size(); ++i) {
    if (is_near_[i] == 0) continue;
    near_.push_back(i);
    near_descriptors_.push_back(lost_[i].last_descriptor);
  }
  return !near_.empty();
}

std::vector<Candidate> Voting::candidates_for(std::span<const Descriptor> views) {
  proposals_.assign(static_cast<std::size_t>((store_.window() + 1) * options_.proposals_per_frame), {no_distance, 0});
  nearest_of_views(views, near_descriptors_, distances_, nearest_);
  for (std::size_t k = 0; k < near_.size(); ++k) {
    if (nearest_[k] <= options_.max_hamming + lost_[near_[k]].spread) propose(near_[k], views);
  }
  return count_votes();
}

void Voting::propose(std::size_t lost_index, std::span<const Descriptor> views) {
  const Track& track = store_[store_.lost()[lost_index]];
  nearest_of_views(views, track.descriptors(), distances_, slot_distances_);
  for (std::size_t slot = 0; slot < track.frames().size(); ++slot) {
    if (track.frames()[slot] < oldest_ || track.frames()[slot] < 0) continue;
    if (slot_distances_[slot] <= options_.max_hamming) keep_best(slot, {slot_distances_[slot], lost_index});
  }
}

void Voting::keep_best(std::size_t slot, const Proposal& proposal) {
  const auto per_frame = static_cast<std::size_t>(options_.proposals_per_frame);
  Proposal* best = proposals_.data() + slot * per_frame;
  // Lost tracks come in ascending order of id, so at equal distance the present one has the smaller id and stays.
  std::size_t rank = per_frame;
  while (rank > 0 && proposal.distance < best[rank - 1].distance) --rank;
  if (rank == per_frame) return;
  std::copy_backward(best + rank, best + per_frame - 1, best + per_frame);
  best[rank] = proposal;
}

std::vector<Candidate> Voting::count_votes() const {
  std::vector<Candidate> candidates;
  for (const Proposal& proposal : proposals_) {
    if (proposal.distance == no_distance) continue;
    const std::size_t track = store_.lost()[proposal.lost_index];
    auto found =
        std::find_if(candidates.begin(), candidates.end(), [=](const Candidate& c) { return c.track == track; });
    if (found == candidates.end()) found = candidates.insert(candidates.end(), {track, 0, 0});
    ++found->votes;
    found->distance += proposal.distance;
  }
  std::erase_if(candidates, [&](const Candidate& c) { return c.votes < options_.min_votes; });
  std::sort(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
    if (a.votes != b.votes) return a.votes > b.votes;
    if (a.distance != b.distance) return a.distance < b.distance;
    return store_[a.track].id < store_[b.track].id;
  });
  candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(options_.candidates)));
  return candidates;
}

}  // namespace rastro
