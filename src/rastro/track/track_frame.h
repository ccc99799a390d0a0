// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/base/time.h"

namespace rastro {

enum class TrackState : std::uint8_t {
  tracked,       ///< Tracked by optical flow from the previous frame.
  fresh,         ///< Detected in this frame; "new" in files.
  reidentified,  ///< Detected in this frame and re-identified as a lost feature.
};

/// One feature of one frame.
struct TrackedFeature {
  std::int64_t id = 0;                              ///< Unique in the run, in order of detection from 0.
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< In the image as given (distorted).
  Eigen::Vector2f ray = Eigen::Vector2f::Zero();    ///< Undistorted, normalized (x/z, y/z); NaN without a calibration.
  std::int32_t age = 1;                             ///< Frames in which this id has been observed, this one included.
  TrackState state = TrackState::fresh;
  std::int64_t last_seen = -1;  ///< Frame in which the id was observed before this one; -1 for a new one.
};

/// Why a frame gave fewer features than asked for; `good` when it did not.
enum class TrackHealth : std::uint8_t { good, few_corners, dark_or_blank, abrupt_motion };

/// Time of each stage in milliseconds. May differ between runs.
struct TrackTimes {
  double pyramid_ms = 0, flow_ms = 0, outlier_ms = 0, predict_ms = 0, detect_ms = 0, describe_ms = 0, match_ms = 0,
         validate_ms = 0, total_ms = 0;
};

/// Result of the tracker for one frame. Features are in ascending order of id.
struct TrackFrame {
  std::int64_t index = 0;  ///< Running number of the frames processed, from 0.
  TimeNs stamp = 0;
  std::vector<TrackedFeature> features;
  int tracked = 0;  ///< Tracked from the previous frame.
  int reidentified = 0;
  int fresh = 0;   ///< New ids.
  int lost = 0;    ///< Features of the previous frame that could not be tracked.
  int masked = 0;  ///< Corners and features left out because of the mask.
  TrackHealth health = TrackHealth::good;
  TrackTimes times;
};

const char* name_of(TrackState state);    ///< "tracked", "new", "reidentified".
const char* name_of(TrackHealth health);  ///< "good", "few corners", ...

}  // namespace rastro
