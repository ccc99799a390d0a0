// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/tracking/image_alignment.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// In order: the later, the better.
enum class PoseGrade : std::uint8_t { lost, weak, tracking };

struct PoseVerdict {
  PoseGrade grade = PoseGrade::tracking;
  SlamReason reason = SlamReason::none;
  std::string detail;  ///< The numbers behind the reason.
};

/// Rotation and translation of the camera from one pose to another as one angle, in degrees: how far a point at mean
/// depth moves in the view.
double view_change_deg(const SE3& a_from_b, double mean_inverse_depth);

/// Judges an alignment by what contradicts its pose: both images show different things, a brightness that changed too
/// much: it is lost. Regions where few pixels fit (something hides them) or an uncertain position make it weak, and
/// lost together with a jump. The share of all pixels that fit says little: 0.57 and more where the pose is right
/// (blur, a rolling shutter), up to 1 where uncertain depths allow a wrong one. `jump_deg`: view change between the
/// pose and the one expected.
PoseVerdict judge_pose(const ImageAlignment& alignment, double mean_inverse_depth, double jump_deg,
                       const LsdOptions& options);

}  // namespace rastro
