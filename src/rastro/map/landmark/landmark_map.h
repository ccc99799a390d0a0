// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/camera/camera.h"
#include "rastro/feature/orb.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// What a map of landmarks was made with, which decides what its lengths mean.
enum class LandmarkSensor : std::uint8_t { mono, stereo, rgbd };

/// A frame that is kept, without its pose. Never changes once made.
struct LandmarkKeyframe {
  std::int64_t id = 0;     ///< Running number of the map, from 0, in the order of creation; culled ones leave gaps.
  std::int64_t frame = 0;  ///< Index in the recording.
  TimeNs stamp = 0;
  OrbFeatures features;        ///< Pixels as recorded, distortion included.
  std::vector<float> right_x;  ///< Stereo: where the right camera sees each feature, pixels; < 0: unknown.
  std::vector<float> depths;   ///< Along the optical axis, in the map's unit; 0: unknown. Empty for mono.
};

/// A feature of a keyframe.
struct LandmarkObservation {
  std::int64_t keyframe = 0;  ///< Id.
  std::uint32_t feature = 0;  ///< Index in its features.
  bool operator==(const LandmarkObservation&) const = default;
};

/// A point of the world that several keyframes see.
struct Landmark {
  std::int64_t id = 0;  ///< Running number, in the order of creation; culled ones leave gaps.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();   ///< In the frame of its submap, the map's unit.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< Mean direction from cameras to it, length 1.
  Descriptor descriptor;                                ///< The one nearest to all others of its observations.
  float min_distance = 0.0F, max_distance = 0.0F;       ///< From which it can be recognised.
  std::vector<LandmarkObservation> observations;        ///< By keyframe.
};

struct LandmarkKeyframePose {
  SE3 world_from_camera;     ///< In the frame of its submap.
  int submap = 0;            ///< Submaps that were joined share the smallest number and one frame.
  std::int64_t parent = -1;  ///< In the spanning tree; -1: its root.
};

/// Two keyframes that loop closing or merging tied together.
struct LandmarkTie {
  std::int64_t from = 0, to = 0;
  Sim3 from_from_to;
  int inliers = 0;
};

/// What the unit of a map is worth.
struct MapScale {
  bool metric = false;          ///< False: the unit is arbitrary.
  double relative_sigma = 0.0;  ///< Of the scale, where metric.
  std::string origin;           ///< "arbitrary", "stereo baseline", "depth camera", "a known length", ...
};

/// A map of one camera, two cameras or a depth camera: keyframes and the landmarks they share. What a map file holds.
/// Never changes once published.
struct LandmarkMap {
  std::string method;  ///< "orb"
  LandmarkSensor sensor = LandmarkSensor::mono;
  Camera camera;          ///< Of the (left) pictures as recorded.
  double baseline = 0.0;  ///< Stereo: between both cameras, metres.
  MapScale scale;
  OrbOptions features;  ///< How its features were made; what is localised in it makes them the same way.
  std::vector<std::shared_ptr<const LandmarkKeyframe>> keyframes;  ///< Ids ascend.
  std::vector<LandmarkKeyframePose> poses;                         ///< One a keyframe.
  std::vector<Landmark> landmarks;                                 ///< Ids ascend.
  std::vector<LandmarkTie> ties;
  Trajectory trajectory;  ///< world_from_camera of every frame of submap 0.
};

/// How many landmarks two keyframes share, for all pairs that share at least `least`; Mur-Artal et al. 2015, section
/// III.D. Indices into map.keyframes, first < second, ordered.
struct Covisibility {
  std::uint32_t first = 0, second = 0;
  int shared = 0;
};
std::vector<Covisibility> covisibility_graph(const LandmarkMap& map, int least);

}  // namespace rastro
