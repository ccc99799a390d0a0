// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/synthetic/occluder/occluder_tile.h"

namespace rastro {

struct OccluderOptions {
  std::uint64_t seed = 1;
  double brightness = 110.0;  ///< Mean intensity of the recording, for the same lighting of the occluder.
  double contrast = 40.0;     ///< Standard deviation of the recording's intensity.
};

/// One crossing of the image from side to side.
struct OccluderPass {
  std::int64_t first = 0;   ///< Frame in which it starts, still outside the image.
  std::int64_t frames = 0;  ///< Number of frames until it is outside again on the other side.
  bool to_right = true;
  double occluded_frames =
      7.0;                    ///< Mean number of frames for which the occluder's widest part occludes a point at rest.
  double speed_change = 0.2;  ///< Relative change of the speed during the pass.
  OccluderAppearance appearance;
};

/// A textured post or person that crosses the image again and again, with pauses, so that everything in the image is
/// occluded for 4 to 12 frames at a time and then reappears. The first pass starts in frame 8 to 10. All depends on the
/// seed and the frame number alone: neither the previously drawn frames nor threads matter.
class Occluder {
 public:
  /// Throws Error for images smaller than 32x32.
  Occluder(int width, int height, const OccluderOptions& options);

  /// The pass of a frame, or the next one.
  const OccluderPass& pass_at(std::int64_t frame);
  /// Center of the occluder in that frame, in pixels; outside the image between passes.
  double center_x(std::int64_t frame);

  /// Draws the occluder of a frame into the image. `mask` gets the image's size: 255 where the occluder covers the
  /// pixel, even partly, else 0; no pixel outside the mask is changed.
  void draw(std::int64_t frame, GrayImage& image, GrayImage& mask);

 private:
  void add_pass();
  const OccluderTile& tile_of(const OccluderPass& pass);

  int width_, height_;
  OccluderOptions options_;
  std::vector<OccluderPass> passes_;
  std::int64_t painted_first_ = -1;  ///< `first` of the pass of tile_.
  OccluderTile tile_;
};

}  // namespace rastro
