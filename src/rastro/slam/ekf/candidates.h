// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/slam/ekf/motion_model.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/ekf/sighting.h"

namespace rastro {

/// Things seen that may become landmarks: only what was seen at the same place in `observations` frames does, with no
/// more than `candidate_frames` between two of them. So people and noise stay out of the map. Candidates are kept
/// relative to the body and moved by odometry alone, so a correction of the filter does not tear them from what is
/// seen.
class Candidates {
 public:
  explicit Candidates(const EkfOptions& options) : options_(options) {}

  void move(const Motion& motion);
  /// True when this sighting is the one that makes a landmark, which then is a candidate no more. Its place is to be
  /// taken from this sighting alone: the earlier ones were made from poses that the filter does not remember.
  bool confirms(const Sighting& sighting, std::int64_t frame);
  /// Drops those not seen for too long.
  void forget(std::int64_t frame);
  std::size_t count() const { return candidates_.size(); }

 private:
  struct Candidate {
    Sighting seen;  ///< Relative to the body of now.
    int observations = 1;
    std::int64_t last_frame = 0;
  };

  bool may_be(const Candidate& candidate, const Sighting& sighting) const;

  EkfOptions options_;
  std::vector<Candidate> candidates_;
};

}  // namespace rastro
