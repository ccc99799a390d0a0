// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/input_check/input_warning.h"
#include "rastro/input_check/tracked_window.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Checks depth images against the gray ones: do steps of the depth lie on edges of the image, or on those of its
/// mirror image? And is it depth at all, or nothing, or one value?
class DepthCheck {
 public:
  /// Adds what is sure since this frame to `found`, each kind once.
  void add(const Frame& frame, InputWarnings& found);
  /// Of the same frames: the motion of features with their depth.
  void add(const TrackedWindow& window, const Camera& camera, InputWarnings& found);
  /// Whether anything was found.
  bool is_wrong() const { return said_ || said_constant_; }

 private:
  /// How much better the depth fits something else than its own image, one number per frame.
  struct Advantage {
    int frames = 0, better = 0;
    double sum = 0.0, own = 0.0, other = 0.0;
    void add(double own_share, double other_share);
    bool is_sure(double least_mean) const;
  };

  void check_presence(const DepthImage& depth, InputWarnings& found);
  void check_spread(const DepthImage& depth, InputWarnings& found);
  void check_steps(const Frame& frame, InputWarnings& found);

  std::int64_t frames_ = 0;
  int empty_ = 0, filled_ = 0;
  bool said_empty_ = false;
  int constant_ = 0, varied_ = 0;
  bool said_constant_ = false, said_ = false;
  Advantage mirrored_;
  int windows_right_ = 0, windows_mirrored_ = 0;
  double mirror_evidence_ = 0.0;
};

}  // namespace rastro
