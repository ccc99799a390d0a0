// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "rastro/base/stopwatch.h"
#include "rastro/feature/orb.h"
#include "rastro/place/vocabulary.h"
#include "rastro/slam/lsd/constraint_search.h"
#include "rastro/slam/lsd/keyframe_depths.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/map_depths.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// A frame that tracking hands to mapping.
struct MappingInput {
  enum class Use : std::uint8_t { place, refine, keyframe };

  std::shared_ptr<const LsdFrame> frame;
  std::int64_t keyframe = 0;  ///< It was tracked on this one.
  ImageAlignment tracked;
  Use use = Use::place;  ///< Nothing but its pose; its depths too; as the next keyframe.
  SE3 depth_from_color;  ///< Motion of the camera from the instant of the image to that of a depth camera's depth.
};

/// What tracking gets of the map: the keyframe that frames are tracked on, and where it is.
struct MappedKeyframe {
  CurrentKeyframe keyframe;
  Sim3 world_from_keyframe;
  int submap = 0;
  double scale_error = 0.0;  ///< SemiDenseGraph::scale_error().
};

/// By what a submap was joined to the first.
struct SubmapJoint {
  std::int64_t earlier = 0;  ///< Keyframe of the first submap.
  Matrix6d covariance;       ///< Of a keyframe of the other one relative to it, in the world's axes and unit.
  double scale_variance = 0.0;
};

/// The map: the depths of the newest keyframe, which frames improve, and the graph of all keyframes. "Newest" is the
/// one that frames are tracked on, also where it is an earlier one that goes on.
class LsdMapping {
 public:
  /// Options, sensor and frames outlive this.
  LsdMapping(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames, const LsdPools& pools,
             const SlamContext& context);

  /// The first keyframe of a new submap. Events and times of this and the following go into the update.
  void begin_map(KeyframeDepths first, SlamUpdate& update);
  /// Returns keyframe_from_new if the frame became the keyframe, or an earlier one goes on: its scale is the new unit
  /// in that of the one before.
  std::optional<Sim3> process(const MappingInput& input, SlamUpdate& update);
  /// The camera was found again in an earlier keyframe, which goes on.
  void return_to(std::int64_t id, SlamUpdate& update);
  void add_frame(const PlacedFrame& frame) { graph_.add_frame(frame); }
  /// The map that a killed run is to leave, if the archive wants one now; null: it does not, or making it took more
  /// than a twentieth of the time.
  std::shared_ptr<const Map> map_to_keep();
  /// At the end: the last constraints; then all keyframes are adjusted together.
  void finish(SlamUpdate& update);

  bool has_keyframe() const { return depths_.has_value(); }
  KeyframeDepths& depths() { return *depths_; }  ///< Of the newest keyframe, if there is one.
  MappedKeyframe current() const;
  /// Of the last join since this was asked.
  std::optional<SubmapJoint> take_joint() { return std::exchange(joint_, std::nullopt); }
  const SemiDenseGraph& graph() const { return graph_; }
  const LsdPools& pools() const { return pools_; }
  KeyframeDepths restored_keyframe(std::int64_t id) const;
  BagOfWords words_of(const LsdFrame& frame) { return words_of(frame.image.view(), frame.mask.view()); }
  MapMemory memory() const;

 private:
  /// How the newest keyframe was made of the one before.
  struct Change {
    std::int64_t before = -1;
    Sim3 before_from_new;
    double gain = 1.0, offset = 0.0;  ///< Intensity in the new one = gain * intensity before + offset.
    double share_of_new = 0.0;        ///< Of its view, that was not in that of the one before.
  };

  /// What a killed run leaves. Only that may depend on time.
  struct Safe {
    const MapArchive* archive = nullptr;  ///< Null: nothing is kept safe.
    KnownMapDepths known = {};
    Stopwatch since = {};      ///< The last map was made.
    double snapshot_ms = 0.0;  ///< Time that it took.
  };

  Sim3 change_keyframe(const MappingInput& input, SlamUpdate& update);
  std::optional<Sim3> go_on_in_earlier(const MappingInput& input, SlamUpdate& update);
  void refine(const LsdFrame& frame, const ImageAlignment& tracked);
  std::optional<ImageAlignment> on_newest(const MappingInput& input) const;
  void finish_keyframe(SlamUpdate& update);
  void connect(std::int64_t id, const BagOfWords& words, SlamUpdate& update);
  bool connect_before(std::int64_t id, SlamUpdate& update);
  bool add_constraints(const std::vector<Constraint>& found, SlamUpdate& update);
  void join(const Constraint& edge, SlamUpdate& update);
  void stay_within_budget(SlamUpdate& update);
  bool is_stopped() const { return stop_ != nullptr && stop_->load(); }
  BagOfWords words_of(GrayView image, GrayView mask);

  const LsdOptions& options_;
  const LsdSensor& sensor_;
  const LsdFrameMaker& frames_;
  LsdPools pools_;
  SemiDenseGraph graph_;
  ConstraintSearch constraints_;
  OrbExtractor features_;
  std::optional<KeyframeDepths> depths_;
  bool is_finished_ = false;  ///< The newest keyframe is an earlier one that goes on: it has its constraints.
  Change change_;
  std::optional<SubmapJoint> joint_;
  const std::atomic<bool>* stop_;  ///< The run is interrupted: what is optional is left out. May be null.
  StepsShown on_finishing_;
  Safe safe_;
  std::size_t budget_bytes_;    ///< 0: none.
  std::int64_t forgotten_ = 0;  ///< Keyframes without depths.
};

}  // namespace rastro
