// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/backend/pipeline.h"
#include "rastro/backend/rgbd/mapper.h"
#include "rastro/backend/rgbd/relocalizer.h"
#include "rastro/backend/rgbd/tracked_appearance.h"
#include "rastro/backend/rgbd/tracked_map.h"
#include "rastro/base/stopwatch.h"
#include "rastro/odometry/rgbd_tracking/camera_motion.h"
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"
#include "rastro/slam/motion_check.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// The keyframe that poses are relative to, and how surely they are.
struct RgbdAnchor {
  std::int64_t keyframe = -1;
  SE3 world_from_keyframe;                           ///< In the follower's world.
  Matrix6d covariance = Matrix6d::Zero();            ///< Of the keyframe, from the graph.
  SE3 world_from_reference;                          ///< What the follower's covariance counts from.
  Matrix6d reference_covariance = Matrix6d::Zero();  ///< Of the reference as seen from the keyframe.
};

/// One session of RGB-D SLAM, from the first frame or a reset on: follows the camera, makes keyframes for the mapper,
/// relocalizes after a loss.
class RgbdSession {
 public:
  struct Method {
    std::string name = "rgbd";
    std::unique_ptr<LoopSearch> search = nullptr;  ///< Null for a GraphSearch.
    double baseline = 0.0;                         ///< Of the pair that gives the depth, meters; 0: a depth camera.
  };
  RgbdSession(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context);
  RgbdSession(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context, Method method);

  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory() const { return map_.trajectory(); }
  std::shared_ptr<const Map> snapshot() const { return map_.snapshot(); }
  bool set_mapping(bool on);
  std::vector<FeatureObservation> observations() const;
  std::int64_t dropped_frames() const { return pipeline_.statistics().dropped; }
  const MapMemory& map_memory() const { return mapping_state_.memory; }
  const std::vector<PlaceBelief>& places() const { return map_.places(); }

 private:
  /// What mapping made of a keyframe.
  struct MappedKeyframe {
    std::int64_t keyframe = 0;
    int segment = 0;
    MapRevision revision;
  };

  struct FrameCounts {
    std::int64_t seen = 0;       ///< Frames given, of any kind.
    std::int64_t anchored = 0;   ///< `seen` when the last keyframe was made.
    std::int64_t localized = 0;  ///< `seen` when a frame was last matched to the map while mapping was off.
  };
  struct Following {
    bool has_pose = true;         ///< False: the follower knows no pose to go on from.
    bool has_last_frame = false;  ///< The last frame was given to the follower.
    MotionCheck motion_check;
    CameraMotion motion{};  ///< As the follower sees it.
    TrackedAppearance appearance;
    bool doubtful = false;  ///< The last frame's pose: it does not look like it.
  };
  /// A lost frame found in the map, not believed yet.
  struct UnconfirmedFrame {
    TimeNs stamp = 0;
    std::int64_t keyframe = 0;
    SE3 keyframe_from_camera;
  };
  struct Loss {
    bool lost = false;
    TimeNs since = 0;                             ///< Stamp of the first lost frame.
    int frames = 0;                               ///< Since, with something to see in them.
    std::vector<UnconfirmedFrame> unconfirmed{};  ///< In a row.
  };

  struct Safekeeping {
    MapArchive* archive = nullptr;  ///< Null: nothing is kept safe.
    Stopwatch since{};              ///< The last snapshot was handed over.
    double snapshot_ms = 0.0;       ///< What it took.
  };

  void keep_safe(bool has_grown);
  bool exists() const { return anchor_.keyframe >= 0; }
  void follow(const Frame& frame, SlamUpdate& update);
  void on_pose(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update);
  void on_loss(const Frame& frame, SlamUpdate& update);
  void move(const SE3& new_world_from_world);
  Frame as_keyframe(const Frame& frame) const;
  void relocalize(const Frame& frame, SlamUpdate& update);
  std::optional<Relocalizer::Found> find_in_map(const Frame& frame, SlamUpdate& update);
  bool confirm(const Frame& frame, const Relocalizer::Found& found, SlamUpdate& update);
  bool agrees_with_last(TimeNs stamp, const SE3& world_from_camera) const;
  bool just_lost() const;
  void doubt(const Frame& frame, RgbdFollow& followed);
  bool is_doubtful_return(const RgbdFollow& followed, SlamUpdate& update);
  bool continues_motion(const SE3& world_from_camera) const;
  void on_relocalized(const Frame& frame, const Relocalizer::Found& found, SlamUpdate& update);
  bool start_again(const Frame& frame, const SE3& world_from_camera, const std::optional<Constraint>& constraint,
                   SlamUpdate& update);
  std::vector<std::int64_t> hinted_keyframes() const;
  void anchor_at(std::int64_t keyframe, const KeyframeConstraint& constraint);
  Matrix6d covariance_of(const SE3& pose, const Matrix6d& from_keyframe) const;
  void update_pose(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update);
  void localize(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update);
  bool revisit(const Frame& frame, const SE3& pose, const Matrix6d& from_keyframe, SlamUpdate& update);
  std::vector<std::int64_t> keyframes_near(const SE3& pose) const;
  std::vector<std::shared_ptr<const ImageFeatures>> with_features(const std::vector<std::int64_t>& ids) const;
  std::vector<std::int64_t> known_here(const SE3& pose) const;
  void connect(const Constraint& edge, TimeNs stamp);
  bool has_moved(const RgbdFollow& followed) const;
  bool needs_keyframe(const RgbdFollow& followed) const;
  void make_keyframe(const Frame& frame, const SE3& world_from_camera, const std::optional<Constraint>& constraint,
                     SlamUpdate& update);
  Constraint path_edge(const SE3& world_from_camera, const Matrix6d& covariance) const;
  void apply(MappedKeyframe mapped, std::vector<SlamEvent>& events);
  void say_pose(const SE3& world_from_camera, const Matrix6d& covariance, SlamUpdate& update);

  RgbdSlamOptions options_;
  Camera camera_;
  bool maps_;  ///< False: localization in a map given.
  StepsShown on_finishing_;
  bool mapping_ = true;  ///< False: switched off for now.
  Mapper mapper_;
  TrackedMap map_;
  Relocalizer relocalizer_;
  RgbdFollower follower_;
  RgbdAnchor anchor_;
  Safekeeping safe_;
  FrameCounts counts_;
  Following following_;
  Loss loss_;
  int segment_ = 0;  ///< Number of the segment of frames followed without a break.
  SE3 last_pose_;
  std::optional<SE3> hint_;  ///< Where to search first in a given map, until found.
  MappingState mapping_state_;
  std::vector<SlamEvent> events_;      ///< Not yet told of.
  Pipeline<MappedKeyframe> pipeline_;  ///< Last: its jobs use what is above.
};

}  // namespace rastro
