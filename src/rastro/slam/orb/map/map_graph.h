// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"
#include "rastro/slam/orb/map/feature_frame.h"

namespace rastro {

struct BagOfWords;

/// How many landmarks a keyframe shares with another.
struct Neighbor {
  std::int64_t id = 0;
  int shared = 0;
  bool operator==(const Neighbor&) const = default;
};

/// A keyframe of the map in the making.
struct MapKeyframe {
  std::int64_t id = 0;
  std::shared_ptr<const FeatureFrame> frame;
  std::shared_ptr<const BagOfWords> words;  ///< Null where there is no vocabulary.
  SE3 camera_from_world;                    ///< World: of its submap.
  int submap = 0;
  /// Length now of what had length 1 when the keyframe was made: whoever rescales the map around it multiplies this.
  double unit = 1.0;
  std::int64_t parent = -1;             ///< In the spanning tree; -1: root of its submap.
  std::vector<std::int64_t> children;   ///< Ascending.
  std::vector<std::int64_t> landmarks;  ///< One a feature; -1: none.
  std::vector<Neighbor> neighbors;      ///< All that share at least one landmark, ids ascending.
};

/// A landmark of the map in the making.
struct MapLandmark {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< World of its submap.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  Descriptor descriptor;
  float min_distance = 0.0F, max_distance = 0.0F;
  std::vector<LandmarkObservation> observations;  ///< Keyframes ascending; at most one a keyframe.
  std::int64_t first_keyframe = 0;                ///< That made it.
  int visible = 1, found = 1;                     ///< Frames that should have seen it, and that did.
};

/// The map in the making: keyframes, landmarks, who sees what, covisibility (always up to date) and the spanning tree
/// (Mur-Artal et al. 2015, section III). Ids are running numbers and never used again; every list is in their order.
/// Not for two threads at once.
class MapGraph {
 public:
  MapGraph(const Camera& camera, CameraKind sensor, double baseline, const OrbOptions& features);

  const Camera& camera() const { return camera_; }
  CameraKind sensor() const { return sensor_; }
  double baseline() const { return baseline_; }  ///< Stereo and RGB-D (made up there); 0: mono.
  const OrbOptions& orb_options() const { return orb_options_; }
  const std::vector<double>& level_scales() const { return level_scales_; }
  /// Standard deviation of a feature's place, normalised.
  double sigma(const FeatureFrame& frame, std::size_t feature) const;

  /// Its id is frame->data().id, larger than all before. No landmarks yet.
  MapKeyframe& add_keyframe(std::shared_ptr<const FeatureFrame> frame, const SE3& camera_from_world, int submap,
                            std::int64_t parent);
  bool has_keyframe(std::int64_t id) const;
  MapKeyframe& keyframe(std::int64_t id);  ///< Must exist, as below.
  const MapKeyframe& keyframe(std::int64_t id) const;
  std::vector<std::int64_t> keyframe_ids() const;
  std::vector<std::int64_t> keyframe_ids(int submap) const;
  std::size_t keyframe_count() const { return keyframe_count_; }
  /// Of all that were ever added, also if it is gone; -1: none.
  std::int64_t newest_keyframe() const { return static_cast<std::int64_t>(keyframes_.size()) - 1; }
  /// Its observations go, landmarks left with fewer than two observations too (mono; one where depths are known). Its
  /// children take parents among its parent and each other by covisibility. Not for the root of a submap.
  void remove_keyframe(std::int64_t id);
  /// The last keyframe of a submap that is not begun after all, with its landmarks.
  void remove_root(std::int64_t id);
  /// Also of keyframes that were removed: those keep their place relative to their parent.
  SE3 camera_from_world(std::int64_t id) const;
  double unit(std::int64_t id) const;
  int submap(std::int64_t id) const;
  /// Moves a keyframe to another parent (both in one submap).
  void set_parent(std::int64_t child, std::int64_t parent);
  /// Makes `id` the root of its submap's tree.
  void make_root(std::int64_t id);

  /// Observed by nobody yet; `keyframe` made it.
  MapLandmark& add_landmark(const Eigen::Vector3d& position, std::int64_t keyframe);
  /// One that was saved, with its id, larger than all before; its keyframes are there.
  void restore_landmark(const Landmark& landmark);
  bool has_landmark(std::int64_t id) const;
  MapLandmark& landmark(std::int64_t id);
  const MapLandmark& landmark(std::int64_t id) const;
  /// What became of a landmark by fusing; -1: it is gone.
  std::int64_t current(std::int64_t id) const;
  std::vector<std::int64_t> landmark_ids() const;
  std::size_t landmark_count() const { return landmark_count_; }
  void remove_landmark(std::int64_t id);
  /// Puts `gone` into `kept`: observations move over where that keyframe does not see `kept` yet.
  void fuse(std::int64_t kept, std::int64_t gone);

  /// Does nothing where the keyframe sees the landmark already or the feature has one.
  void add_observation(std::int64_t keyframe, std::uint32_t feature, std::int64_t landmark);
  /// The landmark stays, whatever is left of it.
  void remove_observation(std::int64_t keyframe, std::int64_t landmark);
  /// Feature of the keyframe that sees the landmark; -1: none.
  std::int64_t feature_of(std::int64_t keyframe, std::int64_t landmark) const;
  /// Descriptor, direction and distances from its observations.
  void describe(std::int64_t landmark);

  /// Neighbours that share at least `least`, most first, then by id; at most `count` (0: all).
  std::vector<Neighbor> covisible(std::int64_t keyframe, int least, std::size_t count = 0) const;
  int shared(std::int64_t a, std::int64_t b) const;

  std::vector<Constraint>& ties() { return ties_; }
  const std::vector<Constraint>& ties() const { return ties_; }
  int submap_count() const { return submaps_; }
  int new_submap() { return submaps_++; }
  /// Submaps that were joined share the smallest number: what is `from` moves by `to_from_from` and becomes `to`; its
  /// root gets `parent`, a keyframe of `to`.
  void join(int from, int to, const Sim3& to_from_from, std::int64_t root, std::int64_t parent);
  /// Moves all keyframes and landmarks of a submap (and their units).
  void transform(int submap, const Sim3& new_from_old);

 private:
  struct Removed {
    std::int64_t parent = -1;
    SE3 keyframe_from_parent;  ///< In the parent's unit at the time...
    double parent_unit = 1.0;  ///< ... which is this.
    double unit = 1.0;         ///< The keyframe's own then.
  };
  void move_children(const MapKeyframe& gone);
  void count(std::int64_t a, std::int64_t b, int change);

  Camera camera_;
  CameraKind sensor_;
  double baseline_;
  OrbOptions orb_options_;
  std::vector<double> level_scales_;
  std::vector<std::unique_ptr<MapKeyframe>> keyframes_;  ///< By id; null: removed.
  std::vector<std::unique_ptr<MapLandmark>> landmarks_;  ///< By id; null: removed.
  std::map<std::int64_t, Removed> removed_;
  std::map<std::int64_t, std::int64_t> fused_into_;
  std::size_t keyframe_count_ = 0, landmark_count_ = 0;
  std::vector<Constraint> ties_;
  int submaps_ = 0;
};

}  // namespace rastro
