// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/slam/orb/options.h"

namespace rastro {

/// How many features the next frame needs. A map of one camera grows only where it moves: in a turn, or among people,
/// few landmarks are tracked, and what walks along outvotes them. More features there keep the static scene in the
/// majority.
class FeatureCount {
 public:
  /// `options.features` must be set.
  FeatureCount(const OrbSlamOptions& options, bool one_camera);

  int next() const { return more_ ? most_ : base_; }
  void on_tracked(int inliers);
  void on_lost() { more_ = false; }

 private:
  int base_, most_, few_, enough_;
  bool more_ = false;
};

}  // namespace rastro
