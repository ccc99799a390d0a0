// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Pose of a camera relative to a keyframe's, as a normal distribution.
struct RelativePose {
  SE3 camera_from_keyframe;
  Matrix6d covariance = Matrix6d::Identity();  ///< Of d in true pose = exp(d) * camera_from_keyframe.
};

/// How far two estimates of one pose are apart: squared sigmas of their difference, per degree of freedom.
double contradiction(const RelativePose& a, const RelativePose& b);
/// Their weighted mean. Where they contradict each other, it is as uncertain as that shows.
RelativePose fused(const RelativePose& a, const RelativePose& b);

/// What an alignment keeps of a frame; opaque here.
class DirectView {
 public:
  virtual ~DirectView() = default;
  virtual std::size_t bytes() const = 0;
};

/// Relative poses from the pixels of whole images, which a method may add to those from features. Without one, features
/// alone count. Thread-safe but for view_of(); results depend on the arguments alone.
class DirectAlignment {
 public:
  virtual ~DirectAlignment() = default;
  /// Of a frame as features see it (rectified where they are). `depth_from_color`: motion of the camera from the
  /// instant of the image to that of its depth. Null where the frame has nothing to align.
  virtual std::shared_ptr<const DirectView> view_of(const Frame& frame, const SE3& depth_from_color) const = 0;
  /// A view of view_of() as the keyframe of align(). Null where it lacks depth.
  virtual std::shared_ptr<const DirectView> keyframe_of(const DirectView& view) const = 0;
  /// The camera of `view` relative to that of `keyframe`, which comes from keyframe_of(); nullopt where the images do
  /// not determine it.
  virtual std::optional<RelativePose> align(const DirectView& keyframe, const DirectView& view,
                                            const SE3& camera_from_keyframe_guess) const = 0;
};

/// The newest keyframes that frames can be aligned with.
class DirectKeyframes {
 public:
  explicit DirectKeyframes(std::size_t most) : most_(most) {}
  /// Null is no keyframe.
  void add(std::int64_t id, std::shared_ptr<const DirectView> keyframe);
  const DirectView* find(std::int64_t id) const;
  std::size_t bytes() const;

 private:
  std::size_t most_;
  std::map<std::int64_t, std::shared_ptr<const DirectView>> keyframes_;
};

}  // namespace rastro
