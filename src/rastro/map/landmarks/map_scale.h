// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "rastro/map/graph/map.h"

namespace rastro {

/// A factor that makes a map's unit metres.
struct MapScaleFound {
  double metres_per_unit = 1.0;
  double relative_sigma = 0.0;  ///< 0: not known, as from one length between two positions of the camera.
  std::string from;             ///< "2 known lengths", ...
  int measurements = 0;         ///< How many it rests on.
};

/// A length in the world that somebody measured: between two landmarks, or between two positions of the camera.
struct KnownLength {
  std::int64_t from = 0, to = 0;  ///< Ids of landmarks, or numbers of frames of the recording.
  bool between_frames = false;
  double metres = 0.0;
};

// Each speaks of submap 0 only, and throws Error naming `where` where the map does not hold what is needed.

/// Several lengths: least squares of their differences in metres, with what is left of those as sigma. One between
/// landmarks: sigma is that of their positions, from pixels with the noise of their level of the pyramid.
MapScaleFound scale_from_lengths(const Map& map, std::span<const KnownLength> lengths, const std::string& where);

/// From the trajectory of the camera and a reference that shares its clock, by the similarity between both (Umeyama
/// 1991). Sigma by leaving away one eighth of the trajectory after the other, so that slow drift counts.
MapScaleFound scale_from_reference(const Map& map, const Trajectory& reference, const std::string& where);

/// From the height of a camera that is carried level over flat ground and looks about where it goes: how far below it
/// the landmarks ahead lie most often. Sigma as above.
MapScaleFound scale_from_camera_height(const Map& map, double height_m, const std::string& where);

/// The map of one camera with lengths times what was found.
Map scaled(const Map& map, const MapScaleFound& found);

}  // namespace rastro
