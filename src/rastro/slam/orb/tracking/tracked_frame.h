// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/slam/orb/map/frame_trajectory.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

/// A frame for the trajectory: its pose relative to the keyframe of the view that shares most points with it, and its
/// observations. `pixel_sigma`: standard deviation of a feature's position at the finest level, pixels.
TrackedFrame tracked_frame(const MapGraph& graph, const MapView& view, const FeatureFrame& frame,
                           const TrackingResult& tracked, double pixel_sigma);

/// A frame that is a keyframe.
TrackedFrame tracked_keyframe(const MapGraph& graph, const FeatureFrame& frame, std::int64_t keyframe);

}  // namespace rastro
