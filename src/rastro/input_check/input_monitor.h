// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/input_check/input_warning.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Watches the frames of a run for input that contradicts its calibration or its other sensors: a swapped or
/// unsynchronized pair, depth that is not of the image, a wrong focal length, a laser that is stuck or mirrored,
/// odometry with the wrong sign. Changes nothing, and looks at few frames. Says nothing where the evidence is thin.
class InputMonitor {
 public:
  explicit InputMonitor(const SourceInfo& info);
  ~InputMonitor();

  /// In the order of the recording. Returns what became sure with this frame, each kind once. Never throws for bad
  /// data.
  InputWarnings add(const Frame& frame);
  /// All so far.
  const InputWarnings& warnings() const;

 private:
  struct Checks;
  std::unique_ptr<Checks> checks_;
};

}  // namespace rastro
