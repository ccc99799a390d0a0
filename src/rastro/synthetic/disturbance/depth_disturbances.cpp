// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <deque>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/synthetic/disturbance/disturbance_parts.h"

namespace rastro::disturbance {
namespace {

void require_depth(const SourceInfo& info) {
  if (!info.has_depth) throw Error("has no depth", info.path, "omit the disturbance of depth");
}

/// Changes every measured depth of a frame.
template <typename Map>
Change of_each_depth(Map map) {
  return {require_depth, [map](Frame& frame) {
            for (int y = 0; y < frame.depth.height(); ++y) {
              float* row = frame.depth.row(y);
              std::transform(row, row + frame.depth.width(), row, [&](float z) { return z > 0.0F ? map(z) : z; });
            }
            return true;
          }};
}

}  // namespace

Change mirror_depth(const Value&) {
  return {require_depth, [](Frame& frame) {
            for (int y = 0; y < frame.depth.height(); ++y)
              std::reverse(frame.depth.row(y), frame.depth.row(y) + frame.depth.width());
            return true;
          }};
}

Change constant_depth(const Value& meters) {
  return of_each_depth([depth = static_cast<float>(meters.factor())](float) { return depth; });
}

Change depth_scale(const Value& factor) {
  return of_each_depth([factor = static_cast<float>(factor.factor())](float z) { return factor * z; });
}

Change late_depth(const Value& seconds) {
  using Stamped = std::pair<TimeNs, DepthImage>;
  return {require_depth,
          [delay = from_seconds(seconds.amount("seconds")), kept = std::deque<Stamped>()](Frame& frame) mutable {
            if (frame.depth.empty()) return true;
            kept.emplace_back(frame.stamp, std::move(frame.depth));
            while (kept.size() > 1 && kept[1].first <= frame.stamp - delay) kept.pop_front();
            frame.depth = kept.front().second;
            return true;
          }};
}

}  // namespace rastro::disturbance
