// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/synthetic/disturbance/disturbance_parts.h"

namespace rastro::disturbance {
namespace {

void require_scans(const SourceInfo& info) {
  if (!info.has_scan) throw Error("has no laser scans", info.path, "omit the disturbance of scans");
}

void require_odometry(const SourceInfo& info) {
  if (!info.has_odometry) throw Error("has no wheel odometry", info.path, "omit the disturbance of odometry");
}

void scale_ranges(LaserScan& scan, double factor) {
  scan.min_range *= factor;
  scan.max_range *= factor;
  for (float& range : scan.ranges) range = static_cast<float>(factor * static_cast<double>(range));
}

}  // namespace

Change stuck_scan(const Value& from_frame) {
  return {require_scans,
          [first = from_frame.count(), stuck = std::optional<std::vector<float>>()](Frame& frame) mutable {
            if (!frame.scan || frame.index < first) return true;
            if (!stuck) stuck = frame.scan->ranges;
            frame.scan->ranges = *stuck;
            return true;
          }};
}

Change reverse_beams(const Value&) {
  return {require_scans, [](Frame& frame) {
            if (frame.scan) std::reverse(frame.scan->ranges.begin(), frame.scan->ranges.end());
            return true;
          }};
}

Change range_scale(const Value& factor) {
  return {require_scans, [factor = factor.factor()](Frame& frame) {
            if (frame.scan) scale_ranges(*frame.scan, factor);
            return true;
          }};
}

Change reverse_odometry(const Value&) {
  struct Poses {
    SE2 given, reversed;
  };
  return {require_odometry, [last = std::optional<Poses>()](Frame& frame) mutable {
            if (!frame.odometry_from_body) return true;
            const SE2 given = *frame.odometry_from_body;
            if (!last) last = Poses{given, given};
            const SE2 motion = last->given.inverse() * given;
            last = Poses{given, last->reversed * SE2::exp(-motion.log())};
            frame.odometry_from_body = last->reversed;
            return true;
          }};
}

}  // namespace rastro::disturbance
