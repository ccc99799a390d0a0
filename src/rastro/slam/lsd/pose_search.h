// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/slam/lsd/current_keyframe.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"
#include "rastro/slam/lsd/tracking/pose_check.h"

namespace rastro {

/// What the frames before say of the next one.
struct ExpectedMotion {
  SE3 camera_from_keyframe;  ///< Of the last frame with a pose.
  SE3 velocity;              ///< Its motion since the frame before, in the keyframe's unit.
  int missed = 0;            ///< Frames since then without a pose: the view may have changed by so much more.
  /// How far the camera may be from where this motion takes it, in the keyframe's unit; infinite where that is unknown.
  double max_step = std::numeric_limits<double>::infinity();

  SE3 going_on() const { return velocity * camera_from_keyframe; }
};

struct JudgedAlignment {
  ImageAlignment alignment;
  PoseVerdict verdict;
  double jump_deg = 0.0;  ///< View change from what was expected.
};

/// Aligns a frame with a keyframe from several guesses, until one gives a pose without doubt: the motion goes on; it
/// stops; the camera rotated as far as two small images say. A pose that no camera could reach is compared with one
/// from fine levels alone, near the motion that goes on.
class PoseSearch {
 public:
  /// `options` outlives this. `camera`: of the undistorted images.
  PoseSearch(const LsdOptions& options, const Camera& camera) : options_(options), camera_(camera) {}

  /// The first without doubt, else the best.
  JudgedAlignment track(const CurrentKeyframe& keyframe, const Pyramid& image, const ExpectedMotion& expected) const;
  /// From the keyframe's own pose, wherever the camera was before: nothing is a jump.
  JudgedAlignment find(const CurrentKeyframe& keyframe, const Pyramid& image) const;
  /// The frame that `expected.camera_from_keyframe` belongs to.
  void remember(const Pyramid& image) { last_ = small_of(image); }
  void forget() { last_.reset(); }

  struct SmallImage {
    PaddedImage image;
    int level = 0;  ///< It is halved so often.
  };
  /// In which rotations are searched for.
  static SmallImage small_of(const Pyramid& image);

 private:
  JudgedAlignment aligned_from(const SE3& guess, int coarsest_level, const CurrentKeyframe& keyframe,
                               const Pyramid& image, const ExpectedMotion& expected) const;
  SE3 rotation_between(const SmallImage& a, const SmallImage& b) const;

  const LsdOptions& options_;
  Camera camera_;
  std::optional<SmallImage> last_;
};

}  // namespace rastro
