// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/synthetic/occluder/occluder_tile.h"

namespace rastro {

struct OccluderOptions {
  std::uint64_t seed = 1;
  double brightness = 110.0;  ///< Mean grey of the recording, so that the occluder stands in the same light.
  double contrast = 40.0;     ///< Standard deviation of the recording's grey.
};

/// One crossing of the image from side to side.
struct OccluderPass {
  std::int64_t first = 0;   ///< Frame in which it starts, still outside the image.
  std::int64_t frames = 0;  ///< Until it is outside again on the other side.
  bool to_right = true;
  double hidden_frames =
      7.0;  ///< For how long a resting point behind the occluder's widest part is hidden, in the mean.
  double speed_change = 0.2;  ///< Part by which the speed rises and falls during the pass.
  OccluderLook look;
};

/// A textured post or person that crosses the image again and again, with pauses, so that everything in the picture is
/// hidden for 4 to 12 frames at a time and then seen again. The first pass starts in frame 8 to 10. All follows from
/// the seed, frame by frame: no result depends on the frames drawn before or on threads.
class Occluder {
 public:
  /// Throws Error for images smaller than 32x32.
  Occluder(int width, int height, const OccluderOptions& options);

  /// The pass that a frame lies in, or the next one.
  const OccluderPass& pass_at(std::int64_t frame);
  /// Middle of the occluder in that frame, in pixels; outside the image between passes.
  double centre_x(std::int64_t frame);

  /// Draws the occluder of a frame into the image. `mask` gets the image's size: 255 where the occluder covers the
  /// pixel, even by a little, else 0; no pixel outside the mask is changed.
  void draw(std::int64_t frame, GreyImage& image, GreyImage& mask);

 private:
  void add_pass();
  const OccluderTile& tile_of(const OccluderPass& pass);

  int width_, height_;
  OccluderOptions options_;
  std::vector<OccluderPass> passes_;
  std::int64_t painted_first_ = -1;  ///< `first` of the pass that tile_ belongs to.
  OccluderTile tile_;
};

}  // namespace rastro
