// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Makes a picture as another camera at the same place would see it: turned, with another lens. Bilinear.
class PictureWarp {
 public:
  /// `source_from_target`: turns rays of the camera to be made into rays of the one that is there. Both know their
  /// size.
  PictureWarp(const Camera& source, const Camera& target, const SO3& source_from_target);

  /// Black where the source shows nothing. `image` has the size of the source. The same bytes for any pool.
  GreyImage warp(GreyView image, TaskPool* pool) const;
  /// The same for a mask, without mixing; zero also where the source shows nothing, and `margin` pixels around that.
  /// An empty mask stands for one without zeros.
  GreyImage warp_mask(GreyView mask, int margin) const;

 private:
  /// Where a pixel is read, and how much of its right and lower neighbour, in 1/128; x < 0: nowhere.
  struct Tap {
    std::int16_t x = -1, y = -1;
    std::uint8_t right = 0, below = 0;
  };

  int source_width_, source_height_, width_, height_;
  std::vector<Tap> taps_;
};

/// Two cameras as one pair without distortion whose rows show the same (Fusiello, Trucco and Verri 2000, "A compact
/// algorithm for rectification of stereo pairs"): x along the baseline, looking between where both look.
struct StereoRectification {
  Camera camera;            ///< Of both pictures.
  double baseline = 0.0;    ///< Metres.
  SO3 left_from_rectified;  ///< Both rectified cameras are turned alike.
  PictureWarp left, right;
};

/// nullopt where the cameras do not say how large their pictures are, are not of one size, or are not side by side: the
/// right one more than 30 degrees off to the right of the left one, or the two looking more than 40 degrees apart.
std::optional<StereoRectification> rectify_stereo(const Camera& left, const Camera& right, const SE3& left_from_right);

}  // namespace rastro
