// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/map/graph/map.h"
#include "rastro/map/graph/place_belief.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

enum class SlamState : std::uint8_t {
  initializing,  ///< No pose yet.
  tracking,
  weak,         ///< A pose from few measurements: part of it is predicted.
  lost,         ///< No pose was found; the last motion is extrapolated.
  relocalized,  ///< The first pose after `lost` that fits the map again.
};

/// Why a frame is not simply `tracking`.
enum class SlamReason : std::uint8_t {
  none,
  first_frame,
  no_data,             ///< The frame has no data that the method uses: no scan, no image.
  few_returns,         ///< Fewer valid beams, depths or points than a pose needs.
  poor_match,          ///< The measurements fit the map badly.
  degenerate,          ///< One direction is not observable, as along a bare corridor.
  too_few_points,      ///< Fewer features or landmarks than a pose needs.
  few_inliers,         ///< No motion explains enough of the matches.
  no_odometry,         ///< A method that needs odometry got none with this frame.
  dark_or_blank,       ///< An image without structure.
  repeated_frame,      ///< The same data again, or a stamp that does not increase.
  gap,                 ///< Frames are missing: the motion since is too large to track.
  odometry_jumped,     ///< Odometry reports a motion that no vehicle makes.
  blurred,             ///< The image has motion blur.
  not_found,           ///< The frame was not found in the map yet.
  apart,               ///< In a submap that is not connected to the first one yet.
  unconfirmed,         ///< Found in the map, but too few frames agree yet: its pose is not believed.
  implausible_motion,  ///< Only an acceleration explains the pose that hardly any camera is exposed to.
  uncertain_scale,     ///< One camera turned too fast to tell the scale of what came into view.
};

const char* name_of(SlamState state);    ///< "initializing", "tracking", ...
const char* name_of(SlamReason reason);  ///< "none", "first_frame", ...

/// Something worth a line in events.jsonl.
struct SlamEvent {
  /// "keyframe", "loop_closed", "map_revised", "landmark", "submap", "joined", "relocalized", "returned", "memory",
  /// "method".
  std::string kind;
  std::string detail;              ///< One short clause with numbers.
  KeyframeId place = no_keyframe;  ///< Of "relocalized": the keyframe that was recognized.
};

struct StageTime {
  const char* stage;
  double milliseconds;
};

/// A method's result for one frame.
struct SlamUpdate {
  std::int64_t index = 0;  ///< Of the frame in the recording.
  TimeNs stamp = 0;
  SlamState state = SlamState::initializing;
  SlamReason reason = SlamReason::none;
  std::string detail;   ///< The numbers behind the reason ("4 of 180 beams returned, need 20"); may be empty.
  SE3 world_from_body;  ///< As first estimated; trajectory() has later corrections.
  /// Of world_from_body.log() about this pose: translation (m), then rotation (rad), in the world's axes. A planar
  /// method leaves the fixed components at zero. None where the pose is a guess: in a submap apart from the first.
  std::optional<Matrix6d> covariance;
  double score = 0.0;  ///< 0..1, how well the frame fits the map by the method's own measure.
  int used = 0;        ///< Beams, points or landmarks used for the pose.
  std::vector<SlamEvent> events;
  std::vector<StageTime> times;
  double milliseconds = 0.0;
};

/// What a feature of a frame was used for.
enum class ObservationState : std::uint8_t {
  unmatched,     ///< Not matched to anything in the map.
  matched,       ///< Matched to the map; the pose neither uses nor contradicts it.
  outlier,       ///< Matched to a landmark, but inconsistent with the pose.
  inlier,        ///< Matched to a landmark and used for the pose.
  new_landmark,  ///< "new": this frame created a landmark from it.
};

const char* name_of(ObservationState state);  ///< "unmatched", "matched", "outlier", "inlier", "new"

struct FeatureObservation {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< In the image in use (rectified, if it rectifies).
  /// Id in the map's landmark layer; -1: none, not numbered yet, or the map has no such layer.
  std::int64_t landmark = -1;
  ObservationState state = ObservationState::unmatched;
  /// Of a method without images, meters in the body frame; `pixel` is zero then.
  std::optional<Eigen::Vector2d> in_body = std::nullopt;
};

/// Memory of the map, by the method's own count: the same in every run.
struct MapMemory {
  std::size_t bytes = 0;
  std::size_t budget_bytes = 0;   ///< Budget that the method plans with; 0: none.
  std::string measures;           ///< Taken to stay within the budget; empty: none.
  std::size_t passing_bytes = 0;  ///< Of `bytes`, what is gone when the method is: no part of its map.
};

/// A method that estimates poses and a map from frames, METHODS 3 to 8. Frames come in the order of the recording.
/// Results depend on frames, options and seed alone, not on threads.
class Slam {
 public:
  virtual ~Slam() = default;
  /// Accepts any frame: an empty, black, repeated or backward one gives an update that says so.
  virtual SlamUpdate process(const Frame& frame) = 0;
  /// After the last frame: completes pending work. Events as in an update.
  virtual std::vector<SlamEvent> finish() { return {}; }
  /// world_from_body for every frame that has a pose, with all later corrections.
  virtual Trajectory trajectory() const = 0;
  /// The current map. The returned object never changes, whatever the method does afterwards.
  virtual std::shared_ptr<const Map> snapshot() const = 0;

  /// Of a method that recognizes places, what it took each keyframe of this run for, in their order; complete after
  /// finish().
  virtual std::vector<PlaceBelief> places() const { return {}; }

  // For live use.

  /// Forgets all frames and the map made from them, as if newly constructed; settings and a given map stay.
  virtual void reset() = 0;
  /// Off: the map stays as it is and frames are only localized in it. On: mapping continues. Returns whether the method
  /// can switch; where it cannot, nothing changes.
  virtual bool set_mapping(bool /*on*/) { return false; }
  /// The features of the last frame, on request; empty for a method without features. The call changes nothing.
  virtual std::vector<FeatureObservation> observations() const { return {}; }
  /// Frames that a live run could not map because mapping fell behind; always 0 without SlamContext::live.
  virtual std::int64_t dropped_frames() const { return 0; }
  /// Zero bytes if the method does not count.
  virtual MapMemory map_memory() const { return {}; }
};

}  // namespace rastro
