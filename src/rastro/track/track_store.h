// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/feature/brief.h"
#include "rastro/track/klt.h"

namespace rastro {

/// Recent observations of a feature: a ring of those in the current frame and the `window` frames before.
class Track {
 public:
  explicit Track(int window)
      : frames_(static_cast<std::size_t>(window) + 1, -1),
        pixels_(frames_.size()),
        ideals_(frames_.size()),
        descriptors_(frames_.size()) {}

  void start(std::int64_t id);
  void observe(std::int64_t frame, const Eigen::Vector2f& pixel, const Eigen::Vector2f& ideal,
               const Descriptor& descriptor);

  /// The slot in which frame `frame` would be kept.
  std::size_t slot(std::int64_t frame) const { return static_cast<std::size_t>(frame) % frames_.size(); }
  bool seen_in(std::int64_t frame) const { return frame >= 0 && frames_[slot(frame)] == frame; }
  const Eigen::Vector2f& pixel_in(std::int64_t frame) const { return pixels_[slot(frame)]; }
  /// The same, undistorted.
  const Eigen::Vector2f& undistorted_in(std::int64_t frame) const { return ideals_[slot(frame)]; }
  /// By slot. Slots whose frame is -1 or has left the window are invalid.
  const std::vector<std::int64_t>& frames() const { return frames_; }
  const std::vector<Descriptor>& descriptors() const { return descriptors_; }
  const Descriptor& last_descriptor() const { return descriptors_[slot(last_seen)]; }

  /// Keeps the patch of the feature in `frame` unless the last one is less than `interval` frames old.
  void keep_patch(std::int64_t frame, int interval, const Pyramid& pyramid, const Eigen::Vector2f& pixel,
                  int window_px);
  /// The patch kept before the last one, where there is one: old enough not to show what occludes the feature now.
  const KltReference& reference_patch() const { return older_patch_.empty() ? patch_ : older_patch_; }
  const KltReference& newest_patch() const { return patch_; }
  /// The frames of the observations; -1 for none.
  std::int64_t patch_frame() const { return older_patch_.empty() ? patch_frame_ : older_patch_frame_; }
  std::int64_t newest_patch_frame() const { return patch_frame_; }

  std::int64_t id = -1;
  std::int64_t last_seen = -1;
  std::int64_t seen_before = -1;  ///< Observation before the last one; -1 for none.
  std::int32_t age = 0;
  /// The layer (motion in the image) of the track; -1: unknown. Kept by MotionHistory.
  int layer = -1;
  /// Largest distance of the observations' descriptors from the last one's; set by measure_spread().
  int descriptor_spread = 0;
  void measure_spread();

 private:
  std::vector<std::int64_t> frames_;
  std::vector<Eigen::Vector2f> pixels_, ideals_;
  std::vector<Descriptor> descriptors_;
  KltReference patch_, older_patch_;
  std::int64_t patch_frame_ = -1, older_patch_frame_ = -1;
};

/// A feature of the current frame that belongs, or may belong, to a track.
struct Association {
  std::size_t track = 0;
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< In the current frame.
  Eigen::Vector2f ideal = Eigen::Vector2f::Zero();  ///< The same, undistorted.
};

/// All tracks inside the window: those tracked in the current frame and those lost. Memory is reused, so it does not
/// grow with the run.
class TrackStore {
 public:
  explicit TrackStore(int window) : window_(window) {}

  int window() const { return window_; }
  /// All indices are below this.
  std::size_t size() const { return tracks_.size(); }
  /// Index of a new track with the next global id.
  std::size_t create();
  Track& operator[](std::size_t index) { return tracks_[index]; }
  const Track& operator[](std::size_t index) const { return tracks_[index]; }

  /// Lost tracks in ascending order of id.
  const std::vector<std::size_t>& lost() const { return lost_; }
  void mark_lost(std::size_t index);
  void mark_found(std::size_t index);
  /// Removes a track that is not lost.
  void discard(std::size_t index) { unused_.push_back(index); }
  /// Removes lost tracks whose last observation is older than the window of frame `current`.
  void forget_old(std::int64_t current);

 private:
  int window_;
  std::int64_t next_id_ = 0;
  std::vector<Track> tracks_;
  std::vector<std::size_t> unused_;
  std::vector<std::size_t> lost_;
};

}  // namespace rastro
