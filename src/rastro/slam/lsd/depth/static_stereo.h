// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/pyramid.h"
#include "rastro/slam/lsd/depth/epipolar_search.h"

namespace rastro {

struct StaticStereoOptions {
  double baseline = 0.1;            ///< Meters.
  double max_disparity_px = 100.0;  ///< Nearer points have no depth.
  double min_disparity_px = 1.0;    ///< Nor have farther ones.
  double max_check_px = 1.0;  ///< Between both directions, of the level where pixels without a prior are searched.
  EpipolarSearchOptions search;
};

/// Depth of the left pixels of a rectified pair (Engel, Stueckler and Cremers 2015, section III-B): the epipolar search
/// within the prior's interval; without a prior over all disparities, on a level where these are few, in both
/// directions, since nothing else confirms a single pair.
class StaticStereo {
 public:
  /// Images as made by alignment_pyramid(); `camera` of level 0. Intensity in the right image = gain * intensity in the
  /// left one + offset. The pyramids outlive this.
  StaticStereo(const Pyramid& left, const Pyramid& right, const Camera& camera, double gain, double offset,
               const StaticStereoOptions& options);
  void find(const EpipolarQueries& queries, EpipolarMatches& matches) const;
  EpipolarMatch find(int x, int y, const DepthPrior& prior) const;

 private:
  void find_anywhere(const EpipolarQueries& queries, EpipolarMatches& matches) const;
  void check_backward(const EpipolarQueries& coarse, EpipolarMatches& found) const;
  DepthPrior any_depth() const;

  StaticStereoOptions options_;
  double focal_times_baseline_;  ///< Pixels of level 0, meters.
  int level_;                    ///< Where all disparities fit into one search.
  double coarse_;                ///< Pixels of level 0 in one of it.
  EpipolarSearch fine_, coarse_search_, coarse_check_;
};

}  // namespace rastro
