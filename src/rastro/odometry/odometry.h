// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rastro/base/time.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

enum class OdometryState : std::uint8_t {
  initialising,  ///< Waiting for enough motion; poses come later, backwards.
  tracking,
  weak,  ///< The pose is a guess from the motion before, or from little.
  lost,  ///< No pose could be found; the last motion is carried on.
};

/// Why a frame is not plainly `tracking`.
enum class OdometryReason : std::uint8_t {
  none,
  first_frame,
  too_little_parallax,  ///< The camera may have moved, but not enough to tell where.
  no_motion,            ///< The image stands still, and so does the camera.
  pure_rotation,        ///< The image only turned: no translation can be seen.
  too_few_points,       ///< Fewer features or matches than a pose needs.
  few_inliers,          ///< No motion explains enough of the matches.
  dark_or_blank,
  blurred,
  repeated_frame,        ///< The same image, or a stamp that does not go on.
  gap,                   ///< Frames are missing: the motion since is larger than it can be followed over.
  calibration_doubtful,  ///< Another calibration would fit the images clearly better; the poses are as bad as it is.
};

/// What an odometry says of one frame.
struct OdometryUpdate {
  std::int64_t index = 0;  ///< Of the frame in the recording.
  TimeNs stamp = 0;
  OdometryState state = OdometryState::initialising;
  OdometryReason reason = OdometryReason::none;
  std::string detail;       ///< The numbers behind the reason, one short clause ("9 points, need 15"); may be empty.
  SE3 world_from_camera;    ///< World: the first camera. Metres only where a scale source was given.
  bool used = true;         ///< False: the frame told nothing and was left out of the chain.
  int matches = 0;          ///< Points with a partner in an earlier frame.
  int inliers = 0;          ///< Of these, explained by the pose.
  double confidence = 1.0;  ///< 0..1, the method's own measure.
  double milliseconds = 0.0;
};

/// A method that turns the frames of one camera into poses, METHODS 2. Frames come in the order of the recording.
/// Results depend on frames, options and seed alone, not on threads.
class Odometry {
 public:
  virtual ~Odometry() = default;
  /// Any frame is taken: an empty, black or repeated one gives an update that says so. Images of another size than the
  /// first's are an Error.
  virtual OdometryUpdate process(const Frame& frame) = 0;
  /// One pose (world_from_camera) for every frame processed, improved by what was learnt later.
  virtual Trajectory trajectory() const = 0;
};

const char* name_of(OdometryState state);    ///< "tracking", ...
const char* name_of(OdometryReason reason);  ///< "too_little_parallax", ...

}  // namespace rastro
