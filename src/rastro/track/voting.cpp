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
  last_descriptors_.reserve(store.lost().size());
  for (const std::size_t track : store.lost()) last_descriptors_.push_back(store[track].last_descriptor());
}

std::vector<Candidate> Voting::candidates_for(std::span<const Descriptor> views, const Eigen::Vector2f& pixel) {
  proposals_.assign(static_cast<std::size_t>((store_.window() + 1) * options_.proposals_per_frame), {no_distance, 0});
  nearest_of_views(views, last_descriptors_, distances_, nearest_);
  for (std::size_t i = 0; i < last_descriptors_.size(); ++i) {
    if (nearest_[i] <= options_.max_hamming + store_[store_.lost()[i]].descriptor_spread && within_travel(i, pixel)) {
      propose(i, views);
    }
  }
  return count_votes();
}

bool Voting::within_travel(std::size_t lost_index, const Eigen::Vector2f& pixel) const {
  if (options_.max_travel_px <= 0.0 || lost_index >= motions_.size() || !motions_[lost_index]) return true;
  const Track& track = store_[store_.lost()[lost_index]];
  const Eigen::Vector2f travelled = pixel - track.pixel_in(track.last_seen);
  const auto limit = static_cast<float>(options_.max_travel_px);
  // What moves in front may hold most features: then standing still is the better guess.
  return travelled.norm() <= limit || (travelled - *motions_[lost_index]).norm() <= limit;
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
  // Lost tracks come in ascending order of id, so at equal distance the one already there has the smaller id and stays.
  std::size_t place = per_frame;
  while (place > 0 && proposal.distance < best[place - 1].distance) --place;
  if (place == per_frame) return;
  std::copy_backward(best + place, best + per_frame - 1, best + per_frame);
  best[place] = proposal;
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
