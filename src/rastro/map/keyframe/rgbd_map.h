// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/map/keyframe/rgbd_keyframe.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

enum class PoseEdgeKind : std::uint8_t {
  way,   ///< From one keyframe to the next, by odometry.
  near,  ///< Matched to another keyframe of the neighbourhood.
  loop,  ///< Matched to a place seen much earlier.
  join,  ///< Ties two submaps.
};

/// Pose of keyframe `to` as seen from keyframe `from`, with what is known of it.
struct PoseEdge {
  std::int64_t from = 0, to = 0;  ///< Ids of keyframes.
  SE3 from_from_to;               ///< Maps points of camera `to` into camera `from`.
  /// Inverse covariance of d in truth = from_from_to * exp(d), (translation m, rotation rad).
  Matrix6d information = Matrix6d::Identity();
  PoseEdgeKind kind = PoseEdgeKind::way;
  double weight = 1.0;  ///< 0..1, what the robust kernel left of it after the last optimisation.
};

/// Where a keyframe stands.
struct KeyframePose {
  SE3 world_from_camera;  ///< In the frame of its submap.
  int submap = 0;         ///< Submaps that were joined share the smallest number and one frame.
};

/// A map of a depth camera: keyframes, how they are tied together, and where they were found to stand. Clouds, octrees
/// and slices are made from it. What a map file holds. Never changes once published.
struct RgbdMap {
  std::string method;  ///< "rgbd"
  Camera camera;       ///< Of the pictures as recorded, distortion included; depth is registered to it.
  std::vector<std::shared_ptr<const RgbdKeyframe>> keyframes;  ///< keyframes[i]->id == i.
  std::vector<KeyframePose> poses;                             ///< One a keyframe.
  std::vector<PoseEdge> edges;                                 ///< In the order in which they were found.
  std::shared_ptr<const PictureStore> pictures;                ///< Of every keyframe.
  Trajectory trajectory;                                       ///< world_from_camera of every frame of submap 0.
  /// Depth noise of the camera: sigma(z) = depth_sigma_m + depth_sigma_per_m2 * z^2.
  double depth_sigma_m = 0.001, depth_sigma_per_m2 = 0.002;
};

}  // namespace rastro
