// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/base/time.h"
#include "rastro/image/image.h"
#include "rastro/odometry/odometry.h"

namespace rastro {

/// When a frame is not worth looking at, METHODS 2.6. Meaning, range and reason of each stand in add_options().
struct FrameCheckOptions {
  double min_deviation = 5.0;          ///< Grey levels.
  double max_repeat_difference = 0.1;  ///< Grey levels.
  double min_sharpness = 0.5;          ///< Of the running median; 0: no check.
  double max_step_ratio = 2.5;         ///< Of the running median; 0: no check.
  int memory = 15;                     ///< Frames of the running medians.
};

/// Adds the rows of `options` to a method's table; `options` must outlive it.
void add_options(OptionTable& table, FrameCheckOptions& options);

/// What the look at one frame found.
struct FrameCheckResult {
  /// none, dark_or_blank, repeated_frame, blurred or gap; the first of these that holds.
  OdometryReason reason = OdometryReason::none;
  std::string detail;        ///< The numbers behind the reason, one short clause; empty without one.
  double deviation = 0.0;    ///< Standard deviation of the grey levels.
  double difference = -1.0;  ///< Mean absolute difference of grey levels to the frame before; -1 where there is none.
  double sharpness = 1.0;    ///< Gradient against the running median, in the direction where it fell more.
  double step_ratio = 1.0;   ///< Stamp step against the running median; 1 where that is not known yet.

  /// Whether the image can be worked with: after a gap it can, there is only more motion in it.
  bool useful() const { return reason == OdometryReason::none || reason == OdometryReason::gap; }
};

/// Cheap test of every frame before any other work (about 0.1 ms at 1241 x 376): is it dark or blank, the same as the
/// one before, blurred against the frames before, or after missing frames?
class FrameCheck {
 public:
  explicit FrameCheck(const FrameCheckOptions& options = {}) : options_(options) {}

  /// Frames in the order of the recording; all must have the size of the first that is not empty, else Error. An empty
  /// image is a blank one.
  FrameCheckResult check(GreyView image, TimeNs stamp);

 private:
  void check_size(GreyView image);
  double step_ratio(TimeNs step);
  double difference_to_last(GreyView image);
  double sharpness(GreyView image);

  FrameCheckOptions options_;
  int width_ = 0, height_ = 0;
  std::optional<TimeNs> last_stamp_;
  std::vector<std::uint8_t> last_, current_;     ///< Every fourth pixel of every fourth row.
  std::deque<double> steps_, across_, upright_;  ///< Seconds; mean absolute gradients along x and along y.
};

}  // namespace rastro
