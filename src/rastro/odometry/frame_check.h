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

/// Thresholds for rejecting a frame, METHODS 2.6. add_options() gives meaning, range and reason of each.
struct FrameCheckOptions {
  double min_deviation = 5.0;          ///< Intensity, 0..255.
  double max_repeat_difference = 0.1;  ///< Intensity, 0..255.
  double min_sharpness = 0.5;          ///< Share of the running median; 0: no check.
  double max_step_ratio = 2.5;         ///< Multiple of the running median; 0: no check.
  int memory = 15;                     ///< Frames of the running medians.
};

/// Adds the rows of `options` to a method's table; `options` must outlive it.
void add_options(OptionTable& table, FrameCheckOptions& options);

/// Result of checking one frame.
struct FrameCheckResult {
  /// none, dark_or_blank, repeated_frame, blurred or gap; the first of these that applies.
  OdometryReason reason = OdometryReason::none;
  std::string detail;        ///< The numbers behind the reason, one short clause; empty without one.
  double deviation = 0.0;    ///< Standard deviation of the intensities.
  double difference = -1.0;  ///< Mean absolute difference in intensity from the previous frame; -1 where there is none.
  double sharpness = 1.0;    ///< Gradient / running median, in the direction of the larger drop.
  double step_ratio = 1.0;   ///< Stamp step / running median; 1 until the median is known.

  /// Whether the image is usable. After a gap it is; the motion is only larger.
  bool useful() const { return reason == OdometryReason::none || reason == OdometryReason::gap; }
};

/// Cheap test of every frame before any other work (about 0.1 ms at 1241 x 376): is it dark or blank, equal to the
/// previous frame, blurred compared with the previous frames, or after missing frames?
class FrameCheck {
 public:
  explicit FrameCheck(const FrameCheckOptions& options = {}) : options_(options) {}

  /// Frames in the order of the recording. All must have the size of the first non-empty one, else throws Error. An
  /// empty image counts as blank.
  FrameCheckResult check(GrayView image, TimeNs stamp);
  /// The next frame is compared with none before it, so it may be the last one again.
  void forget_last();

 private:
  void check_size(GrayView image);
  double step_ratio(TimeNs step);
  double difference_to_last(GrayView image);
  double sharpness(GrayView image);

  FrameCheckOptions options_;
  int width_ = 0, height_ = 0;
  std::optional<TimeNs> last_stamp_;
  std::vector<std::uint8_t> last_, current_;     ///< Every fourth pixel of every fourth row.
  std::deque<double> steps_, across_, upright_;  ///< Seconds; mean absolute gradients along x and along y.
};

}  // namespace rastro
