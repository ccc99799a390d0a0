// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>
#include <vector>

#include "rastro/export/landmark_parts.h"

namespace rastro {

/// A relative pose as landmarks that two keyframes share give it.
struct CovisiblePose {
  SE3 first_from_second;
  Matrix6d information;  ///< As in Constraint.
};

/// Measures relative poses of keyframes by the landmarks that both observe: the pose of the second one that fits its
/// pixels best where the landmarks lie as seen from the first one. Pixels have the noise of their pyramid level.
class CovisiblePoses {
 public:
  /// The map must outlive this.
  CovisiblePoses(const Map& map, int submap);
  /// Indices into map.keyframes. Starts from the poses of the map; nullopt where fewer than ten landmarks are shared
  /// or they leave the pose open.
  std::optional<CovisiblePose> measure(std::size_t first, std::size_t second) const;
  /// The information alone, at a pose that is known otherwise.
  std::optional<CovisiblePose> judge(std::size_t first, std::size_t second, const SE3& first_from_second) const;

 private:
  struct Observed {
    std::size_t landmark = 0;
    std::uint32_t feature = 0;
  };
  struct Pixel;
  std::optional<CovisiblePose> fitted(std::size_t first, std::size_t second, SE3 pose, int most_steps) const;
  std::vector<Pixel> shared(std::size_t first, std::size_t second) const;

  const Map& map_;
  LandmarkPart part_;
  std::vector<std::vector<Observed>> observed_;  ///< By keyframe; landmarks ascend.
};

}  // namespace rastro
