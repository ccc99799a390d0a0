// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rastro/track/track_store.h"

namespace rastro {

/// A lost track proposed for a corner by `votes` window frames, with the sum of its Hamming distances there.
struct Candidate {
  std::size_t track = 0;
  int votes = 0;
  int distance = 0;
};

struct VotingOptions {
  int max_hamming = 50;         ///< Similarity threshold.
  int proposals_per_frame = 2;  ///< 2: priority matching.
  int candidates = 2;           ///< 2: dual voting.
  int min_votes = 1;
  /// A corner farther than this both from a track's last position and from that position moved like other features is
  /// not compared; 0: no limit.
  double max_travel_px = 0.0;
};

/// Matching and voting of METHODS 1, steps 4 and 5: every window frame proposes the lost features most similar to the
/// corner, and the ids proposed most often are the candidates. Equal votes: the smaller summed distance, then the
/// smaller id wins.
///
/// Gives exactly the result of brute force over all observations, but compares few: by the triangle inequality no
/// observation of a track can match if the track's last one is farther than the threshold plus the track's own spread.
class Voting {
 public:
  /// `current` is the frame whose corners are matched. Keeps references.
  Voting(const TrackStore& store, std::int64_t current, const VotingOptions& options);
  /// Motion of the features since each lost track, in the order of store.lost(), was last observed; nullopt: unknown.
  /// Only used with max_travel_px.
  void expect(const std::vector<std::optional<Eigen::Vector2f>>& motions);
  /// From now on compares only with the lost tracks that may be at `pixel`; returns whether there are any. Initially
  /// all are compared.
  bool select_near(const Eigen::Vector2f& pixel);
  /// Up to `candidates` candidates, best first. `descriptors`: one, or several views (scales), of which each
  /// observation uses the nearest.
  std::vector<Candidate> candidates_for(std::span<const Descriptor> descriptors);

 private:
  struct Proposal {
    int distance;
    std::size_t lost_index;
  };
  void propose(std::size_t lost_index, std::span<const Descriptor> views);
  void keep_best(std::size_t slot, const Proposal& proposal);
  std::vector<Candidate> count_votes() const;

  const TrackStore& store_;
  std::int64_t oldest_;
  VotingOptions options_;
  struct Lost {
    Descriptor last_descriptor;
    Eigen::Vector2f last_pixel;
    int spread;
  };
  std::vector<float> x_, y_, moved_x_,
      moved_y_;                        ///< Last positions of the lost tracks, and those moved like other features.
  std::vector<std::int32_t> is_near_;  ///< Scratch.
  std::vector<Lost> lost_;             ///< Data of each lost track, contiguous.
  std::vector<std::size_t> near_;      ///< Lost tracks to compare with.
  std::vector<Descriptor> near_descriptors_;   ///< Their last descriptors.
  std::vector<std::uint16_t> nearest_;         ///< Scratch: to the last descriptors.
  std::vector<std::uint16_t> distances_;       ///< Scratch.
  std::vector<std::uint16_t> slot_distances_;  ///< Scratch: to a track's observations.
  std::vector<Proposal> proposals_;            ///< proposals_per_frame for every slot of the window, best first.
};

}  // namespace rastro
