// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "rastro/map/keyframe/rgbd_map.h"
#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// Where a map that grows is kept safe while the run goes on, and where pictures go instead of memory. Called by one
/// thread at a time; pictures() of the store by any.
class MapArchive {
 public:
  virtual ~MapArchive() = default;
  /// What the whole map shares; once, before anything else. Of `map` only what is no list is read.
  virtual void begin(const RgbdMap& map) = 0;
  virtual void add_keyframe(const RgbdKeyframe& keyframe, const KeyframePose& pose, PackedPictures pictures) = 0;
  virtual void add_edge(const PoseEdge& edge) = 0;
  /// New poses of the keyframes with ids 0, 1, ..., after an optimisation or a join.
  virtual void set_poses(const std::vector<KeyframePose>& poses) = 0;
  /// One more frame; written late, but by less than a second. Never waits; may come from another thread than the rest.
  virtual void add_pose(const StampedPose& world_from_camera) = 0;
  /// The pictures added so far.
  virtual std::shared_ptr<const PictureStore> pictures() const = 0;

  /// For maps of landmarks, instead of all of the above: takes the map as it stands, to be written in the background.
  /// Never waits. Each replaces the one before; about one a second is written.
  virtual void keep(std::shared_ptr<const LandmarkMap> map) = 0;
  /// Whether a map given to keep() now would be written soon; where not, it need not be put together. Only how safe a
  /// run is may depend on it, never a result.
  virtual bool wants_map() const = 0;
};

}  // namespace rastro
