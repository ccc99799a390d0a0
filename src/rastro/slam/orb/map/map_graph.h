// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "rastro/base/id_table.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/math/packed_se3.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"
#include "rastro/slam/orb/direct_alignment.h"
#include "rastro/slam/orb/map/feature_frame.h"
#include "rastro/slam/orb/map/fused_landmarks.h"

namespace rastro {

struct BagOfWords;

/// Number of landmarks a keyframe shares with another.
struct Neighbor {
  std::int64_t id = 0;
  int shared = 0;
  bool operator==(const Neighbor&) const = default;
};

/// A keyframe of the map under construction.
struct MapKeyframe {
  std::int64_t id = 0;
  std::shared_ptr<const FeatureFrame> frame;
  std::shared_ptr<const BagOfWords> words;  ///< Null where there is no vocabulary.
  SE3 camera_from_world;                    ///< World: of its submap.
  int submap = 0;
  /// Current length of what had length 1 when the keyframe was made. Every rescaling of the map around it multiplies
  /// this.
  double unit = 1.0;
  std::int64_t parent = -1;             ///< In the spanning tree; -1: root of its submap.
  std::vector<std::int64_t> children;   ///< Ascending.
  std::vector<std::int64_t> landmarks;  ///< One per feature; -1: none.
  std::vector<Neighbor> neighbors;      ///< All that share at least one landmark, ids ascending.
};

/// A landmark of the map under construction.
struct MapLandmark {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< In the world of its submap.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  Descriptor descriptor;
  float min_distance = 0.0F, max_distance = 0.0F;
  std::vector<LandmarkObservation> observations;  ///< Keyframes ascending; at most one per keyframe.
  std::int64_t first_keyframe = 0;                ///< The keyframe that created it.
  int visible = 1, found = 1;                     ///< Numbers of frames where it should be visible, and was found.
};

/// Pose of one keyframe's camera relative to another's, from whole images.
struct DirectPose {
  std::int64_t keyframe = 0, camera = 0;  ///< Keyframes; the pose is that of `camera` relative to `keyframe`.
  RelativePose pose;
};

/// The map under construction: keyframes, landmarks, observations, covisibility (always up to date) and the spanning
/// tree (Mur-Artal et al. 2015, section III). Ids are running numbers and never reused; every list is in their order.
/// Not thread-safe.
class MapGraph {
 public:
  MapGraph(const Camera& camera, CameraKind sensor, double baseline, const OrbOptions& features);

  const Camera& camera() const { return camera_; }
  CameraKind sensor() const { return sensor_; }
  double baseline() const { return baseline_; }  ///< Stereo and RGB-D (virtual there); 0: mono.
  const OrbOptions& orb_options() const { return orb_options_; }
  const std::vector<double>& level_scales() const { return level_scales_; }
  /// Standard deviation of a feature's position, normalized.
  double sigma(const FeatureFrame& frame, std::size_t feature) const;

  /// Its id is frame->data().id, larger than all before. No landmarks yet.
  MapKeyframe& add_keyframe(std::shared_ptr<const FeatureFrame> frame, const SE3& camera_from_world, int submap,
                            std::int64_t parent);
  bool has_keyframe(std::int64_t id) const;
  MapKeyframe& keyframe(std::int64_t id);  ///< Must exist; also below.
  const MapKeyframe& keyframe(std::int64_t id) const;
  std::vector<std::int64_t> keyframe_ids() const;
  std::vector<std::int64_t> keyframe_ids(int submap) const;
  std::size_t keyframe_count() const { return keyframe_count_; }
  /// Largest id ever added, even if that keyframe was removed; -1: none.
  std::int64_t newest_keyframe() const { return static_cast<std::int64_t>(keyframes_.size()) - 1; }
  /// Removes its observations, and landmarks left with fewer than two observations (mono; one where depths are known).
  /// Its children get new parents among its parent and each other, by covisibility. Not for the root of a submap.
  void remove_keyframe(std::int64_t id);
  /// Those removed by remove_keyframe() since the last call.
  std::vector<std::int64_t> take_removed() { return std::exchange(newly_removed_, {}); }
  /// Removes the last keyframe of a submap, with its landmarks, when its initialization is undone.
  void remove_root(std::int64_t id);
  /// Also for removed keyframes: those keep their pose relative to their parent.
  SE3 camera_from_world(std::int64_t id) const;
  double unit(std::int64_t id) const;
  int submap(std::int64_t id) const;
  /// Moves a keyframe to another parent in the same submap.
  void set_parent(std::int64_t child, std::int64_t parent);
  /// Makes `id` the root of its submap's tree.
  void make_root(std::int64_t id);

  /// Without observations; `keyframe` created it.
  MapLandmark& add_landmark(const Eigen::Vector3d& position, std::int64_t keyframe);
  /// Adds a saved landmark with its id, larger than all before; its keyframes must exist.
  void restore_landmark(const Landmark& landmark);
  bool has_landmark(std::int64_t id) const;
  MapLandmark& landmark(std::int64_t id);
  const MapLandmark& landmark(std::int64_t id) const;
  /// The landmark that it was fused into, or itself; -1: removed, or fused so long ago that no frame refers to it.
  std::int64_t current(std::int64_t id) const;
  std::vector<std::int64_t> landmark_ids() const;
  std::size_t landmark_count() const { return landmark_count_; }
  void remove_landmark(std::int64_t id);
  /// Fuses `gone` into `kept`: observations move over where the keyframe does not observe `kept` yet.
  void fuse(std::int64_t kept, std::int64_t gone);

  /// Does nothing if the keyframe observes the landmark already or the feature has one.
  void add_observation(std::int64_t keyframe, std::uint32_t feature, std::int64_t landmark);
  /// Keeps the landmark, whatever observations are left.
  void remove_observation(std::int64_t keyframe, std::int64_t landmark);
  /// Feature of the keyframe that observes the landmark; -1: none.
  std::int64_t feature_of(std::int64_t keyframe, std::int64_t landmark) const;
  /// Updates descriptor, direction and distances from its observations.
  void describe(std::int64_t landmark);

  /// Neighbors that share at least `least` landmarks, most first, then by id; at most `count` (0: all).
  std::vector<Neighbor> covisible(std::int64_t keyframe, int least, std::size_t count = 0) const;
  int shared(std::int64_t a, std::int64_t b) const;

  std::vector<Constraint>& constraints() { return constraints_; }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  /// Those of removed keyframes go with them.
  std::vector<DirectPose>& direct_poses() { return direct_poses_; }
  const std::vector<DirectPose>& direct_poses() const { return direct_poses_; }
  int submap_count() const { return submaps_; }
  int new_submap() { return submaps_++; }
  /// Merges two submaps; merged submaps share the smallest number. `from` is transformed by `to_from_from` and becomes
  /// part of `to`; its root gets `parent`, a keyframe of `to`.
  void merge(int from, int to, const Sim3& to_from_from, std::int64_t root, std::int64_t parent);
  /// Transforms all keyframes and landmarks of a submap (and their units).
  void transform(int submap, const Sim3& new_from_old);

 private:
  struct Removed {
    std::int64_t parent;
    PackedSE3 keyframe_from_parent;  ///< In the parent's unit at the time...
    double parent_unit;              ///< ... which is this.
    double unit;                     ///< The keyframe's own unit then.
  };
  const Removed& removed(std::int64_t id) const;
  void move_children(const MapKeyframe& gone);
  MapLandmark& add_landmark(std::int64_t id, const Eigen::Vector3d& position, std::int64_t keyframe);
  void count(std::int64_t a, std::int64_t b, int change);

  Camera camera_;
  CameraKind sensor_;
  double baseline_;
  OrbOptions orb_options_;
  std::vector<double> level_scales_;
  std::vector<std::unique_ptr<MapKeyframe>> keyframes_;  ///< By id; null: removed.
  IdTable<MapLandmark> landmarks_;
  /// By id. Not a node each: small ones that stay, between large ones that go, keep whole pages of memory.
  std::vector<std::pair<std::int64_t, Removed>> removed_;
  std::vector<std::int64_t> newly_removed_;
  FusedLandmarks fused_{16000};  ///< Frames refer to landmarks for 600 frames, with up to 25 fused in each.
  std::size_t keyframe_count_ = 0, landmark_count_ = 0;
  std::vector<Constraint> constraints_;
  std::vector<DirectPose> direct_poses_;
  int submaps_ = 0;
};

}  // namespace rastro
