// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// A SLAM method that suits a source, and why.
struct MethodChoice {
  std::string method;
  std::string reason;  ///< One clause: "a depth camera, corners in 87 % of the image".
};

/// Share of the cells of an image, 8 by 6, that have an ORB keypoint in the image as it is, with corners of
/// `threshold` gray levels; 0 for an empty image.
double texture_of(GrayView image, int threshold);

/// The methods for a source, best first. `texture`: of its first image, see texture_of(). `live`: it does not wait, so
/// the faster one where two are good. Error where there is none for what the source has.
std::vector<MethodChoice> slam_choices(const SourceInfo& source, double texture, double least_texture,
                                       bool live = false);

/// The odometry for a source. Error where there is none.
MethodChoice odometry_choice(const SourceInfo& source);

}  // namespace rastro
