// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "rastro/multiview/point_pairs.h"
#include "rastro/track/options.h"
#include "rastro/track/track_store.h"

namespace rastro {

/// Geometric validation of proposals, METHODS 1, steps 6 and 7: does a corner lie where the motion of the other
/// features since some window frame predicts the track? The motion from a window frame is estimated once, on first use.
class Validation {
 public:
  /// `associations`: the tracked features and the first proposals (one per track); those observed in a window frame
  /// give its motion.
  Validation(const TrackStore& store, std::int64_t current, std::span<const Association> associations,
             const TrackOptions& options);
  ~Validation();

  /// Whether any window frame that observed the track confirms it at `pixel`; the newest is tried first.
  bool confirms(std::size_t track, const Eigen::Vector2f& pixel);
  /// Motions estimated so far.
  int estimated() const { return static_cast<int>(models_.size()); }

  /// The motion from one window frame to the current one.
  class Model {
   public:
    virtual ~Model() = default;
    virtual bool agrees(const Eigen::Vector2d& in_window_frame, const Eigen::Vector2d& in_current) const = 0;
  };

 private:
  const Model* model_of(std::int64_t frame);
  std::unique_ptr<Model> estimate(std::int64_t frame) const;

  const TrackStore& store_;
  std::int64_t current_;
  std::span<const Association> associations_;
  const TrackOptions& options_;
  std::map<std::int64_t, std::unique_ptr<Model>> models_;
};

}  // namespace rastro
