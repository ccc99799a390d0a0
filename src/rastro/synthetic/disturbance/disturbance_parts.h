// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "rastro/sensor/source.h"

namespace rastro::disturbance {

/// What a disturbance does to a source. Unset parts do nothing.
struct Change {
  std::function<void(SourceInfo&)> info;  ///< Throws Error where the source lacks what is to be disturbed.
  std::function<bool(Frame&)> frame;      ///< In the order of the frames; false: the frame is dropped.
};

/// The value of an assignment, parsed as the disturbance needs it. Each throws Error naming the disturbance.
struct Value {
  std::string name;
  std::string text;

  /// More than zero.
  double factor() const;
  /// Zero or more.
  double amount(const char* unit) const;
  std::int64_t count() const;
};

/// Frames [first, end) by their numbers in the recording.
struct FrameRange {
  std::int64_t first = 0, end = 0;
  bool holds(const Frame& frame) const { return frame.index >= first && frame.index < end; }
};
FrameRange frames_of(const Value& value);

// Images.
Change none(const Value&);
Change black(const Value& frames);
Change freeze(const Value& frames);
Change drop(const Value& frames);
Change noise(const Value& sigma);
Change color_cast(const Value& factor);
Change blur(const Value& pixels);
Change dark(const Value& factor);
Change crowd(const Value& share);

// The calibrated camera or pair.
Change swap_stereo(const Value&);
Change late_right(const Value& frames);
Change baseline(const Value& factor);
Change focal_length(const Value& factor);

// Depth.
Change mirror_depth(const Value&);
Change constant_depth(const Value& meters);
Change late_depth(const Value& seconds);
Change depth_scale(const Value& factor);

// Laser and wheels.
Change stuck_scan(const Value& from_frame);
Change reverse_beams(const Value&);
Change range_scale(const Value& factor);
Change reverse_odometry(const Value&);

}  // namespace rastro::disturbance
