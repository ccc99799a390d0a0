// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

enum class OdometryState : std::uint8_t {
  initializing,  ///< Waiting for enough motion; these poses are filled in later.
  tracking,
  weak,  ///< The pose is a prediction, or rests on little data.
  lost,  ///< No pose could be estimated; the last motion is repeated.
};

/// Why a frame's state is not plain `tracking`.
enum class OdometryReason : std::uint8_t {
  none,
  first_frame,
  too_little_parallax,  ///< The camera may have moved, but not enough to tell in which direction.
  no_motion,            ///< The image does not change: the camera is at rest.
  pure_rotation,        ///< Rotation only: the translation cannot be observed.
  too_few_points,       ///< Fewer features or matches than a pose needs.
  few_inliers,          ///< No motion fits enough of the matches.
  dark_or_blank,
  blurred,
  repeated_frame,        ///< The same image, or a stamp that does not increase.
  gap,                   ///< Frames are missing: the motion may be too large to track across.
  calibration_doubtful,  ///< Another calibration would fit the images clearly better; the poses share its error.
};

/// What an odometry reports for one frame.
struct OdometryUpdate {
  std::int64_t index = 0;  ///< Frame number in the recording.
  TimeNs stamp = 0;
  OdometryState state = OdometryState::initializing;
  OdometryReason reason = OdometryReason::none;
  std::string detail;       ///< The numbers behind the reason, one short clause ("9 points, need 15"); may be empty.
  SE3 world_from_camera;    ///< World: the first camera. Metric only with a source of scale.
  bool used = true;         ///< False: the frame had no information and was left out of the chain.
  int matches = 0;          ///< Points matched with an earlier frame.
  int inliers = 0;          ///< Of these, consistent with the pose.
  double confidence = 1.0;  ///< 0..1, the method's own measure.
  double milliseconds = 0.0;
};

/// A feature of the last frame, and what it was used for.
struct OdometryFeature {
  enum class State : std::uint8_t {
    matched,  ///< With an earlier frame; the pose neither uses nor contradicts it.
    outlier,  ///< Matched to a point, but inconsistent with the pose.
    inlier,   ///< Matched to a point and used for the pose.
    fresh,    ///< Of no earlier frame.
  };
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  std::int64_t id = -1;  ///< The same in all frames; -1: none.
  State state = State::matched;
};

/// Interface of a visual odometry, METHODS 2: estimates the poses of one camera. Frames come in the order of the
/// recording. Results depend on frames, options and seed alone, not on threads.
class Odometry {
 public:
  virtual ~Odometry() = default;
  /// Accepts any frame: an empty, black or repeated one gives an update that says so. Throws Error for an image of
  /// another size than the first.
  virtual OdometryUpdate process(const Frame& frame) = 0;
  /// One pose (world_from_camera) for every processed frame, improved by all later information.
  virtual Trajectory trajectory() const = 0;
  /// Of the last frame, on request; empty for a method without features. The call changes nothing.
  virtual std::vector<OdometryFeature> features() const { return {}; }
};

const char* name_of(OdometryState state);    ///< "tracking", ...
const char* name_of(OdometryReason reason);  ///< "too_little_parallax", ...

}  // namespace rastro
