// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

/// 256 binary tests packed in four words; compared by Hamming distance.
struct alignas(32) Descriptor {
  std::array<std::uint64_t, 4> words{};
  bool operator==(const Descriptor&) const = default;
};

/// Number of differing bits, 0..256.
int hamming_distance(const Descriptor& a, const Descriptor& b);

/// One test of BRIEF: is the smoothed intensity at offset (ax, ay) from the corner below that at (bx, by)?
struct BriefTest {
  float ax, ay, bx, by;
};

/// Calonder et al. 2010, "BRIEF", their sampling G II: both ends drawn from an isotropic Gaussian of variance S^2/25
/// around the corner, S the patch's side. The draws are seeded, so descriptors are the same on every machine. The
/// caller smooths the image: tests read box sums (image/box_sum.h).
class Brief {
 public:
  /// `patch_px`: side S of the patch, 8..64.
  Brief(int patch_px, std::uint64_t seed);

  /// Descriptor of the corner at (x, y); outside the image, the pixels at its edge are used.
  Descriptor describe(const Image<std::uint16_t>& sums, float x, float y) const {
    return describe(sums, x, y, 0.0, 1.0);
  }
  /// Steered: the pattern rotated by `angle_rad` (rounded to 360/32 degrees) and scaled by the nearest of scales().
  Descriptor describe(const Image<std::uint16_t>& sums, float x, float y, double angle_rad, double scale) const;

  static const std::vector<double>& scales();

 private:
  /// Pixels from the corner to both ends of every test.
  struct Pattern {
    std::array<std::int8_t, 256> ax, ay, bx, by;
  };
  static Descriptor compare_plain(const Pattern& pattern, const std::uint16_t* center, std::ptrdiff_t stride);
  static Descriptor compare_avx2(const Pattern& pattern, const std::uint16_t* center, std::ptrdiff_t stride);
  const Pattern& pattern_of(double angle_rad, double scale) const;

  std::vector<Pattern> patterns_;  ///< By scale, then angle.
  int reach_ = 0;                  ///< Largest offset of any test.
};

/// Direction of the intensity centroid in a disc around (x, y) (Rosin 1999; ORB 2011 section 3.2), radians.
double intensity_centroid_angle(GrayView image, float x, float y, int radius);

}  // namespace rastro
