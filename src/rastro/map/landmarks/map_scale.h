// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "rastro/map/graph/map.h"

namespace rastro {

/// The factor from a map's unit to meters.
struct MapScaleFound {
  double meters_per_unit = 1.0;
  double relative_sigma = 0.0;  ///< 0: unknown, as from one length between two positions of the camera.
  std::string from;             ///< "2 known lengths", ...
  int measurements = 0;         ///< Number of measurements used.
  /// Of a reference trajectory: rms distance of the aligned positions, as share of their standard deviation, and rms
  /// difference of the angles turned since the middle of the trajectory. A reference of something else fits badly.
  double position_misfit = 0.0, turn_misfit_deg = 0.0;
};

/// A measured length in the world: between two landmarks, or between two positions of the camera.
struct KnownLength {
  std::int64_t from = 0, to = 0;  ///< Ids of landmarks, or numbers of frames of the first session's recording.
  bool between_frames = false;
  double meters = 0.0;
};

// Each considers submap 0 only, and throws Error naming `where` if the map lacks what is needed.

/// Several lengths: least squares of their differences in meters, with sigma from the residuals. One length between
/// landmarks: sigma from their position covariances, with the pixel noise of their pyramid level.
MapScaleFound scale_from_lengths(const Map& map, std::span<const KnownLength> lengths, const std::string& where);

/// From the trajectory of the camera and a reference with the same clock, by the similarity between both (Umeyama
/// 1991). Sigma by leaving out each eighth of the trajectory in turn, which includes slow drift. `session`: the one
/// whose recording the reference is of; Error where it is not known and sessions overlap in time.
MapScaleFound scale_from_reference(const Map& map, const Trajectory& reference, const std::string& where,
                                   std::optional<std::size_t> session = std::nullopt);

/// The poses that a reference is compared with: of `session`, else of all. Error as above.
Trajectory trajectory_for_reference(const Map& map, std::optional<std::size_t> session, const std::string& where);

/// From the height of a camera that is carried level over flat ground and faces about its direction of travel: the most
/// frequent depth of the landmarks ahead below it. Sigma as above.
MapScaleFound scale_from_camera_height(const Map& map, double height_m, const std::string& where);

/// Where a map's first pose is, which scaling leaves in place: that of its first keyframe; the origin where it has
/// none.
Eigen::Vector3d fixed_point_of(const Map& map);

/// The map of one camera, with lengths scaled by the factor found about its fixed point.
Map scaled(const Map& map, const MapScaleFound& found);

}  // namespace rastro
