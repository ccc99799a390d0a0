// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/slam/lsd/depth/epipolar_search.h"
#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

/// What a pair or a depth camera measured at a pixel of a keyframe, before frames of other places improved it: these
/// follow from the motion, which errors of the depths make too short.
struct SensedDepth {
  std::uint16_t x = 0, y = 0;
  float inverse_depth = 0.0F, sigma = 0.0F;  ///< 1/m.
};

/// Size of the cells that divide an image into about so many; even, so that each consists of four of half the size.
int cell_for(int points, int width, int height);

/// By which pixels are chosen: where intensities change most, depths are most precise.
int squared_gradient(GrayView image, int x, int y);

/// Notes the matches of a sensor, by pixel. Different pixels may be noted by different threads.
class SensedDepthMap {
 public:
  SensedDepthMap(int width, int height) : depth_(width, height) {}
  void note(const EpipolarQueries& queries, const EpipolarMatches& matches);
  /// Of each cell of the image the one where this has the largest gradient.
  std::vector<SensedDepth> thinned(GrayView image, int cell_px) const;

 private:
  InverseDepthMap depth_;
};

/// A sensed inverse depth beside that of the map.
struct DepthRatio {
  double sensed = 0.0, sensed_sigma = 0.0, of_map = 0.0;
};

/// What the map's inverse depths are to be multiplied by to be those that were sensed; 1 where there are too few. The
/// most frequent ratio rather than the mean: beside a near surface, stereo measures that surface, never a farther one.
double sensed_scale(const std::vector<DepthRatio>& ratios);

}  // namespace rastro
