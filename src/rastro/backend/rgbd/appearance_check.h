// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/backend/acceptance.h"
#include "rastro/backend/rgbd/recent_items.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/map/graph/map.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// A keyframe's image in coarse pixels, about 160 across, with depth.
struct KeyframeAppearance {
  Image<float> brightness;
  DepthImage depth;  ///< Of the nearest in each coarse pixel; meters along the optical axis, 0: none.
};

/// Patches of a surface that both views show: textured in two directions in one of them.
struct AppearanceAgreement {
  int agree = 0;       ///< They look alike: correlated, whatever the light.
  int contradict = 0;  ///< They do not.
  int cells = 0;       ///< Of a grid of 8 x 6 over the second view, those with a patch that agrees.
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< Of the patches that agree, in the second camera, meters.

  Evidence evidence() const { return {.patches = agree + contradict, .alike_patches = agree}; }
};

/// Compares what two keyframes show of the same surfaces. Corridors of one make have the same shape, doors and lamps,
/// and features agree on one pose; but stains, notices and furniture differ, each a patch with negative evidence.
/// Thread-safe.
class AppearanceCheck {
 public:
  explicit AppearanceCheck(const Camera& camera, const DepthNoise& noise = {});
  /// Error (naming `where`) for damaged images.
  KeyframeAppearance appearance_of(const PackedImages& images, const std::string& where) const;
  /// As if the frame were packed first.
  KeyframeAppearance appearance_of(const Frame& frame) const;
  AppearanceAgreement compare(const KeyframeAppearance& a, const KeyframeAppearance& b, const SE3& a_from_b) const;
  /// Of one keyframe's.
  std::size_t bytes() const { return rays_.size() * 2 * sizeof(float); }

 private:
  struct Patch;
  bool fill(const KeyframeAppearance& a, const KeyframeAppearance& b, const SE3& a_from_b, Patch& patch) const;

  int coarse_px_;  ///< Pixels along a coarse one.
  Camera camera_;  ///< Of the coarse pixels.
  DepthNoise noise_;
  std::vector<Eigen::Vector3d> rays_;  ///< Of the coarse pixels, z = 1; NaN where there is none.
};

/// The appearance of keyframes, computed from their images on demand. Thread-safe. `check` must outlive this.
class AppearanceStore {
 public:
  /// `most`: that are cached.
  AppearanceStore(const AppearanceCheck& check, std::shared_ptr<const ImageStore> images, std::size_t most = usual_most)
      : check_(check), images_(std::move(images)), recent_(most) {}
  static constexpr std::size_t usual_most = 32;
  std::shared_ptr<const KeyframeAppearance> appearance(std::int64_t keyframe);
  void clear() { recent_.clear(); }  ///< What is cached.
  const AppearanceCheck& check() const { return check_; }

 private:
  const AppearanceCheck& check_;
  std::shared_ptr<const ImageStore> images_;
  RecentItems<KeyframeAppearance> recent_;
};

}  // namespace rastro
