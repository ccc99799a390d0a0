// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <deque>

#include "rastro/base/error.h"
#include "rastro/synthetic/disturbance/disturbance_parts.h"

namespace rastro::disturbance {
namespace {

void require_pair(const SourceInfo& info) {
  if (!info.has_right) throw Error("has no right images", info.path, "omit the disturbance of a stereo pair");
}

void require_camera(const SourceInfo& info) {
  const auto& cameras = info.cameras;
  if (std::none_of(cameras.begin(), cameras.end(), [](const auto& each) { return each.camera.has_value(); }))
    throw Error("has no calibrated camera", info.path, "omit the disturbance of its calibration");
}

}  // namespace

Change swap_stereo(const Value&) {
  return {require_pair, [](Frame& frame) {
            if (!frame.right.empty()) frame.image.swap(frame.right);
            return true;
          }};
}

Change late_right(const Value& frames) {
  return {require_pair,
          [delay = static_cast<std::size_t>(frames.count()), kept = std::deque<GrayImage>()](Frame& frame) mutable {
            if (frame.right.empty()) return true;
            kept.push_back(std::move(frame.right));
            if (kept.size() > delay + 1) kept.pop_front();
            frame.right = kept.front();
            return true;
          }};
}

Change baseline(const Value& factor) {
  return {[factor = factor.factor()](SourceInfo& info) {
            require_pair(info);
            if (!info.left_from_right) throw Error("has no calibrated baseline", info.path, "omit the disturbance");
            const SE3& right = *info.left_from_right;
            info.left_from_right = SE3(right.rotation(), factor * right.translation());
          },
          {}};
}

Change focal_length(const Value& factor) {
  return {[factor = factor.factor()](SourceInfo& info) {
            require_camera(info);
            for (CalibratedCamera& each : info.cameras) {
              if (!each.camera) continue;
              each.camera->fx *= factor;
              each.camera->fy *= factor;
            }
          },
          {}};
}

}  // namespace rastro::disturbance
