// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/feature_count.h"

#include <cmath>

namespace rastro {
namespace {

int share_of(int features, double share) { return static_cast<int>(std::lround(share * features)); }

}  // namespace

FeatureCount::FeatureCount(const OrbSlamOptions& options, bool one_camera)
    : base_(options.features),
      most_(one_camera ? share_of(options.features, options.more_features) : options.features),
      few_(share_of(options.features, options.few_tracked_share)),
      enough_(share_of(options.features, options.enough_tracked_share)) {}

void FeatureCount::on_tracked(int inliers) {
  if (inliers < few_) more_ = true;
  if (inliers >= enough_) more_ = false;
}

}  // namespace rastro
