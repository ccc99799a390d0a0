// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "rastro/place/vocabulary.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/pose_search.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Finds a lost camera again: near its last pose, or in the keyframes that share most visual words with the frame. What
/// it finds is a hypothesis until several frames in a row follow it without doubt: one frame may fit a wrong keyframe.
/// Only next to the last pose, right after the loss, one is enough.
class LsdRelocalization {
 public:
  using MakeKeyframe = std::function<CurrentKeyframe(std::int64_t id)>;
  struct Confirmed {
    std::optional<CurrentKeyframe> keyframe;  ///< nullopt: the current one goes on.
    std::int64_t id = 0;                      ///< The keyframe's.
    std::vector<PlacedFrame> earlier;         ///< The frames that agreed before this one.
    SE3 last_pose;                            ///< camera_from_keyframe of the frame before; or of this one.
    JudgedAlignment tracked;
  };

  /// All outlive this. `make`: a keyframe of the graph, to be tracked on again.
  LsdRelocalization(const LsdOptions& options, const SemiDenseGraph& graph, MakeKeyframe make)
      : options_(options), graph_(graph), make_(std::move(make)) {}

  /// A frame while the camera is lost. nullopt: not found, or not confirmed yet, as the update says. `was_tried`: the
  /// frame could not be tracked on the current keyframe.
  std::optional<Confirmed> take(const LsdFrame& frame, const CurrentKeyframe& current, const ExpectedMotion& last,
                                const PoseSearch& search, bool was_tried, const std::function<BagOfWords()>& words,
                                SlamUpdate& update);
  void reset() { hypothesis_.reset(); }
  /// Whether there is a hypothesis that too few frames agree with yet.
  bool is_unconfirmed() const { return hypothesis_.has_value(); }

 private:
  struct Hypothesis {
    std::optional<CurrentKeyframe> keyframe;
    std::int64_t id = 0;
    SE3 camera_from_keyframe, before;  ///< Of its last frame, and of the one before.
    std::vector<PlacedFrame> frames;
    PoseSearch search;
    bool is_near = false;  ///< Next to the last pose, right after the loss.
  };
  bool follows(const LsdFrame& frame, const CurrentKeyframe& current);
  bool begin_near(const LsdFrame& frame, const CurrentKeyframe& current, const ExpectedMotion& last,
                  const PoseSearch& search);
  bool begin_similar(const LsdFrame& frame, const BagOfWords& words, const PoseSearch& search, int missed);
  bool is_within_reach(const PlacedFrame& found, int missed) const;
  void add(const LsdFrame& frame, const JudgedAlignment& tracked);

  const LsdOptions& options_;
  const SemiDenseGraph& graph_;
  MakeKeyframe make_;
  std::optional<Hypothesis> hypothesis_;
  JudgedAlignment last_;
};

}  // namespace rastro
