// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/feature_count.h"

#include <cmath>

namespace rastro {
FeatureCount::FeatureCount(const OrbSlamOptions& options, bool one_camera)
    : base_(options.features),
      most_(one_camera ? static_cast<int>(std::lround(options.more_features * options.features)) : options.features),
      few_(options.few_tracked),
      enough_(options.enough_tracked) {}

void FeatureCount::on_tracked(int inliers) {
  if (inliers < few_) more_ = true;
  if (inliers >= enough_) more_ = false;
}

}  // namespace rastro
