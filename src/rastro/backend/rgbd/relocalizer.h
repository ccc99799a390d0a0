// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/backend/rgbd/appearance_check.h"
#include "rastro/backend/rgbd/depth_store.h"
#include "rastro/backend/rgbd/keyframe_features.h"
#include "rastro/backend/rgbd/keyframe_matcher.h"

namespace rastro {

/// Relocalizes a frame against keyframes, a few of them per attempt: the last ones, some at random, and one after the
/// other all.
class Relocalizer {
 public:
  /// The stores must outlive this.
  Relocalizer(const RgbdSlamOptions& options, const Camera& camera, DepthStore& depths, AppearanceStore& appearances);

  struct Found {
    std::int64_t keyframe = 0;
    KeyframeConstraint constraint;  ///< From the keyframe to the frame.
    bool looks_alike = false;       ///< Not only its shape and its features: see AppearanceCheck.
  };
  struct Try {
    std::optional<Found> found;  ///< The one with most inliers, among those that look alike if there are any.
    int features = 0, compared = 0;
  };
  /// Where to search first; the others are skipped if one of these matches.
  struct First {
    std::vector<std::int64_t> ids{};
    /// Keyframes that look like the frame.
    std::function<std::vector<std::shared_ptr<const ImageFeatures>>(const ImageFeatures& seen)> similar{};
  };
  Try find(const Frame& frame, const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes, std::uint64_t seed,
           const First& first);
  Try find(const Frame& frame, const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes, std::uint64_t seed) {
    return find(frame, keyframes, seed, First());
  }
  /// Compares with these only.
  std::optional<Found> find_among(const Frame& frame,
                                  const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes,
                                  std::uint64_t seed);

 private:
  struct Choice {
    std::int64_t keyframe = 0;
    std::shared_ptr<const ImageFeatures> features;
  };
  void compare(const ImageFeatures& seen, const Frame& frame, const std::vector<Choice>& choices, std::uint64_t seed,
               Try& result);
  void compare(const ImageFeatures& seen, const Frame& frame,
               const std::vector<std::shared_ptr<const ImageFeatures>>& keyframes, const std::vector<std::int64_t>& ids,
               std::uint64_t seed, Try& result);
  std::vector<std::int64_t> candidates(std::int64_t count, std::uint64_t seed);
  bool looks_alike(const KeyframeAppearance& frame, std::int64_t keyframe, const SE3& keyframe_from_frame);

  RgbdSlamOptions options_;
  DepthStore& depths_;
  AppearanceStore& appearances_;
  KeyframeFeatures features_;
  KeyframeMatcher matcher_;
  std::int64_t next_in_order_ = 0;
};

}  // namespace rastro
