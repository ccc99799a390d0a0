// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/track/options.h"
#include "rastro/track/track_frame.h"

namespace rastro {

/// Occlusion-robust feature tracks: KLT with re-identification of features lost within a window of frames. Galardi,
/// Castro, Pire: "Seguimiento Robusto de Caracteristicas Visuales para Sistemas SLAM".
class Tracker {
 public:
  /// Throws Error for settings out of range. `camera` gives the undistorted rays; without it they are NaN.
  /// The pool must outlive the tracker; without one everything runs in the caller's thread. Results do not depend on
  /// it.
  explicit Tracker(const TrackOptions& options, std::optional<Camera> camera = std::nullopt, TaskPool* pool = nullptr);
  ~Tracker();
  Tracker(Tracker&&) noexcept;

  /// Tracks, detects and re-identifies features in the next frame. All frames must have one size (else throws Error).
  /// `mask`: zero where nothing may be detected or tracked; empty for none; else of the size of the image.
  TrackFrame process(GrayView image, TimeNs stamp, GrayView mask = {});

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
