// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rastro/track/track_store.h"

namespace rastro {

/// A lost track proposed for a corner by `votes` window frames, its Hamming distances there summed up.
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
  /// A corner farther from a track's last place, and from that place moved like other features, is not compared; 0: no
  /// limit.
  double max_travel_px = 0.0;
};

/// Matching and voting of METHODS 1, steps 4 and 5: every window frame proposes the lost features most like the corner,
/// and the ids proposed most often are the candidates. Ties go to the smaller summed distance, then the smaller id.
///
/// Gives exactly the result of brute force over all observations, but looks at few: by the triangle inequality no
/// observation of a track can be alike when the track's last one is farther than the threshold plus the track's own
/// spread.
class Voting {
 public:
  /// `current` is the frame whose corners are asked about. Keeps references.
  Voting(const TrackStore& store, std::int64_t current, const VotingOptions& options);
  /// How features moved since each lost track, in the order of store.lost(), was last seen; nullopt: not known. Only
  /// used with max_travel_px.
  void expect(const std::vector<std::optional<Eigen::Vector2f>>& motions);
  /// Compares from now on only with the lost tracks that may be at `pixel`; says whether there are any. At first all
  /// are compared.
  bool select_near(const Eigen::Vector2f& pixel);
  /// Up to `candidates` candidates, best first. `descriptors`: one, or several views (scales) of which each observation
  /// takes the nearest.
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
      moved_y_;                                ///< Last places of the lost tracks, and those places moved like others.
  std::vector<std::int32_t> is_near_;          ///< Scratch.
  std::vector<Lost> lost_;                     ///< What is needed of each lost track, side by side.
  std::vector<std::size_t> near_;              ///< Lost tracks to compare with.
  std::vector<Descriptor> near_descriptors_;   ///< Their last descriptors.
  std::vector<std::uint16_t> nearest_;         ///< Scratch: to the last descriptors.
  std::vector<std::uint16_t> distances_;       ///< Scratch.
  std::vector<std::uint16_t> slot_distances_;  ///< Scratch: to a track's observations.
  std::vector<Proposal> proposals_;            ///< proposals_per_frame for every slot of the window, best first.
};

}  // namespace rastro
