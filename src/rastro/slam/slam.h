// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/map/graph/map.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

enum class SlamState : std::uint8_t {
  initialising,  ///< No pose yet.
  tracking,
  weak,         ///< A pose, but from little: part of it is a guess.
  lost,         ///< No pose could be found; the last motion is carried on.
  relocalised,  ///< The first pose after `lost` that fits the map again.
};

/// Why a frame is not plainly `tracking`.
enum class SlamReason : std::uint8_t {
  none,
  first_frame,
  no_data,          ///< The frame holds nothing that the method uses: no scan, no image.
  few_returns,      ///< Fewer valid beams, depths or points than a pose needs.
  poor_match,       ///< What was seen fits the map badly.
  degenerate,       ///< One direction cannot be seen, as along a bare corridor.
  too_few_points,   ///< Fewer features or landmarks than a pose needs.
  few_inliers,      ///< No motion explains enough of the matches.
  no_odometry,      ///< A method that needs odometry got none with this frame.
  dark_or_blank,    ///< An image without structure.
  repeated_frame,   ///< The same data, or a stamp that does not go on.
  gap,              ///< Frames are missing: the motion since is larger than it can be followed over.
  odometry_jumped,  ///< Odometry says a motion that no vehicle makes.
  blurred,          ///< The image is smeared by motion.
  not_found,        ///< What is seen was not found in the map yet.
  apart,            ///< In a part of the map that nothing ties to the first one yet.
};

const char* name_of(SlamState state);    ///< "initialising", "tracking", ...
const char* name_of(SlamReason reason);  ///< "none", "first_frame", ...

/// Something worth a line in events.jsonl.
struct SlamEvent {
  std::string
      kind;  ///< "keyframe", "loop_closed", "map_revised", "landmark", "submap", "joined", "relocalised", "memory".
  std::string detail;  ///< One short clause with numbers.
};

struct StageTime {
  const char* stage;
  double milliseconds;
};

/// What a method says of one frame.
struct SlamUpdate {
  std::int64_t index = 0;  ///< Of the frame in the recording.
  TimeNs stamp = 0;
  SlamState state = SlamState::initialising;
  SlamReason reason = SlamReason::none;
  std::string detail;   ///< The numbers behind the reason ("4 of 180 beams returned, need 20"); may be empty.
  SE3 world_from_body;  ///< As first known; trajectory() has what was learnt later.
  /// Of world_from_body.log() about this pose: translation (m), then rotation (rad), in the world's axes. A planar
  /// method leaves what it cannot move at zero.
  std::optional<Matrix6d> covariance;
  double score = 0.0;  ///< 0..1, how well the frame fits the map, the method's own measure.
  int used = 0;        ///< Beams, points or landmarks that the pose rests on.
  std::vector<SlamEvent> events;
  std::vector<StageTime> times;
  double milliseconds = 0.0;
};

/// What became of a feature of a frame.
enum class ObservationState : std::uint8_t {
  unmatched,  ///< Shows nothing that the map knows.
  outlier,    ///< Matched to a landmark that the pose contradicts.
  inlier,     ///< Matched to a landmark, and the pose rests on it.
};

struct FeatureObservation {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< Of the image that the method works on (rectified, if it does).
  std::int64_t landmark = -1;                       ///< Id in the map's landmark layer; -1: none.
  ObservationState state = ObservationState::unmatched;
};

/// A method that turns frames into poses and a map of its own, METHODS 3 to 8. Frames come in the order of the
/// recording. Results depend on frames, options and seed alone, not on threads.
class Slam {
 public:
  virtual ~Slam() = default;
  /// Any frame is taken: an empty, black, repeated or backward one gives an update that says so.
  virtual SlamUpdate process(const Frame& frame) = 0;
  /// After the last frame: whatever the method still has to settle. Events as in an update.
  virtual std::vector<SlamEvent> finish() { return {}; }
  /// world_from_body for every frame that has a pose, with what was learnt later.
  virtual Trajectory trajectory() const = 0;
  /// The map as it stands. Never changes afterwards, whatever the method goes on to do.
  virtual std::shared_ptr<const Map> snapshot() const = 0;

  // For live use.

  /// Forgets all frames and the map made of them, as if just made; settings, and a map given, stay.
  virtual void reset() = 0;
  /// Off: the map stays as it is and frames are only localized in it; on again: mapping goes on. Returns whether the
  /// method can switch; where it cannot, nothing changes.
  virtual bool set_mapping(bool /*on*/) { return false; }
  /// The features of the last frame, for those who ask; empty for a method without any.
  virtual std::vector<FeatureObservation> observations() const { return {}; }
};

}  // namespace rastro
