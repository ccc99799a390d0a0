// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/slam/rgbd/depth_store.h"
#include "rastro/slam/rgbd/keyframe_features.h"
#include "rastro/slam/rgbd/keyframe_matcher.h"

namespace rastro {

/// Finds a frame again among keyframes, a few of them at each try: the last ones, some at random, and by turns all.
class Relocaliser {
 public:
  /// `depths` must outlive this.
  Relocaliser(const RgbdSlamOptions& options, const Camera& camera, DepthStore& depths);

  struct Found {
    std::int64_t keyframe = 0;
    KeyframeTie tie;  ///< From the keyframe to the frame.
  };
  struct Try {
    std::optional<Found> found;  ///< The one with most inliers.
    int features = 0, compared = 0;
  };
  Try find(const Frame& frame, const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes, std::uint64_t seed);

 private:
  std::vector<std::int64_t> candidates(std::int64_t count, std::uint64_t seed);

  RgbdSlamOptions options_;
  DepthStore& depths_;
  KeyframeFeatures features_;
  KeyframeMatcher matcher_;
  std::int64_t next_by_turns_ = 0;
};

}  // namespace rastro
