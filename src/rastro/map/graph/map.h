// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/camera/camera.h"
#include "rastro/map/graph/constraint.h"
#include "rastro/map/graph/keyframe_id.h"
#include "rastro/map/layer.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// What a camera of the map measures, which determines the scale.
enum class CameraKind : std::uint8_t { mono, stereo, depth, none };
const char* name_of(CameraKind kind);  ///< "one camera", "two cameras", "depth camera", "no camera"

/// Standard deviation of a measured depth z: sigma_m + sigma_per_m2 * z^2.
struct DepthNoise {
  double sigma_m = 0.001, sigma_per_m2 = 0.002;
  double sigma(double depth_m) const { return sigma_m + sigma_per_m2 * depth_m * depth_m; }
  bool operator==(const DepthNoise&) const = default;
};

struct MapCamera {
  CameraKind kind = CameraKind::mono;
  Camera intrinsics;    ///< Of the (left) images as recorded, distortion included; depth is registered to it.
  double baseline = 0;  ///< Stereo: between both cameras, meters.
  DepthNoise depth_noise;
  SE3 body_from_camera;
};

/// The scale of a map's unit.
struct MapScale {
  bool metric = false;          ///< False: the unit is arbitrary.
  double relative_sigma = 0.0;  ///< Standard deviation of the scale relative to it; 0: unknown.
  std::string origin;           ///< "arbitrary", "stereo baseline", "depth camera", "a known length", ...
};

/// One run on the map.
struct MapSession {
  int robot = 0, session = 0;  ///< As in the ids of its keyframes.
  std::string recording;       ///< Path as given; may be empty.
  TimeNs first_stamp = 0, last_stamp = 0;
  MapScale scale;
};

/// A frame kept in the map.
struct Keyframe {
  KeyframeId id = 0;
  std::int64_t frame = 0;  ///< Index in the recording.
  TimeNs stamp = 0;
  int camera = 0;                   ///< Into Map::cameras.
  SE3 world_from_camera;            ///< In the frame of its submap; of the body where there is no camera.
  int submap = 0;                   ///< Merged submaps share the smallest number and one frame.
  KeyframeId parent = no_keyframe;  ///< In the spanning tree; no_keyframe: its root.
  double weight = 1.0;              ///< Number of observations of the same location that it represents.
};

/// Any frame, relative to a keyframe, so that it follows corrections of the map.
struct MapFrame {
  TimeNs stamp = 0;
  KeyframeId keyframe = 0;
  SE3 keyframe_from_camera;
};

/// A pose graph of keyframes that carry layers, from any method and sensor. Immutable once published.
struct Map {
  std::string method;         ///< The method that made it: "orb", "rgbd", ...
  std::int64_t revision = 0;  ///< Increases with every change.
  std::vector<MapCamera> cameras;
  std::vector<MapSession> sessions;
  std::vector<Keyframe> keyframes;      ///< Ids ascend.
  std::vector<Constraint> constraints;  ///< In the order in which they were found.
  std::vector<MapFrame> frames;         ///< In the order of the recording.
  LayerSet layers;

  /// Index into keyframes.
  std::optional<std::size_t> index_of(KeyframeId id) const;
  const Keyframe* find(KeyframeId id) const;  ///< Null where there is none.
  /// Null where the map has no such layer.
  template <typename L>
  std::shared_ptr<const L> layer() const {
    return layers.get<L>();
  }
};

/// world_from_camera of the frames in a submap, or in several, in the order of their stamps, each stamp once: of all
/// sessions, but where these overlap in time, of the last one alone that has poses there (see sessions.h).
Trajectory trajectory_of(const Map& map, int submap = 0);
Trajectory trajectory_of(const Map& map, const std::set<int>& submaps);

/// Of the keyframes of a submap, by stamp.
Trajectory keyframe_trajectory(const Map& map, int submap = 0);

/// A frame relative to a keyframe of the map: the last one of the submap whose stamp is not later, else the first.
/// nullopt where the submap has no keyframe.
std::optional<MapFrame> frame_in(const Map& map, const StampedPose& world_from_camera, int submap = 0);

/// The scale of the first session; arbitrary where there is none.
const MapScale& scale_of(const Map& map);

/// The first camera. Error naming `where` for a map without one.
const MapCamera& camera_of(const Map& map, const std::string& where);

/// The first inconsistency of a map, as a clause such as "has keyframes out of order"; empty if there is none: ids
/// ascend, every reference is valid, poses are finite, constraints can be optimized, the spanning tree is one, every
/// layer is consistent.
std::string contradiction_in(const Map& map);

}  // namespace rastro
