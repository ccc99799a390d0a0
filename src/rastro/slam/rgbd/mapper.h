// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/map/map_archive.h"
#include "rastro/slam/rgbd/depth_store.h"
#include "rastro/slam/rgbd/keyframe_features.h"
#include "rastro/slam/rgbd/keyframe_graph.h"
#include "rastro/slam/rgbd/keyframe_matcher.h"
#include "rastro/slam/rgbd/options.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// What the mapper is given to make a keyframe of.
struct KeyframeOrder {
  std::int64_t id = 0;
  Frame frame;                   ///< Picture, colour, depth and mask alone are read.
  SE3 world_from_camera;         ///< Where the tracker has it.
  int submap = 0;                ///< As far as the tracker knows.
  std::vector<Constraint> ties;  ///< To this keyframe: by odometry, or by which it was found again.
};

/// What became of it, and of the map.
struct MapRevision {
  std::shared_ptr<const ImageFeatures> keyframe;
  std::vector<KeyframePose> poses;  ///< Of all keyframes up to this one.
  std::vector<Constraint> new_edges;
  std::vector<double> weights;             ///< Of all edges up to these.
  Matrix6d covariance = Matrix6d::Zero();  ///< Of the keyframe's pose, see KeyframeGraph.
  std::vector<std::int64_t> forgotten;     ///< Keyframes that lost their features.
  std::vector<SlamEvent> events;
};

/// Makes the map: each keyframe's features, whom it matches, the graph, the archive. Runs beside the tracker, one job
/// after the other; what it knows depends on its orders alone.
class Mapper {
 public:
  Mapper(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context);
  MapRevision add(const KeyframeOrder& order);
  /// All keyframes once more over all ties; the keyframe of the result stays null.
  MapRevision settle();

  const std::shared_ptr<const PictureStore>& pictures() const { return pictures_; }
  /// May be asked by any thread.
  DepthStore& depths() { return depths_; }

 private:
  void keep(const KeyframeOrder& order, ImageFeatures keyframe);
  void tie(std::int64_t id, MapRevision& revision);
  std::optional<Constraint> compare(std::int64_t other, std::int64_t id);
  void add_edge(const Constraint& edge, MapRevision& revision);
  void stay_below_ceiling(MapRevision& revision);
  void revise(MapRevision& revision) const;

  RgbdSlamOptions options_;
  Camera camera_;
  MapArchive* archive_;
  bool maps_;  ///< Else the map given is only looked at.
  std::size_t ceiling_bytes_ = 0, bytes_ = 0;
  std::int64_t next_forgotten_ = 0;
  std::shared_ptr<MemoryPictures> in_memory_;
  std::shared_ptr<const PictureStore> pictures_;
  KeyframeMatcher matcher_;
  DepthStore depths_;
  KeyframeFeatures features_;
  KeyframeGraph graph_;
};

}  // namespace rastro
