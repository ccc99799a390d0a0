// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "rastro/feature/brief.h"
#include "rastro/image/image.h"

namespace rastro {

struct Keypoint {
  float x = 0.0F, y = 0.0F;  ///< Pixels.
  float size_px = 0.0F;      ///< Diameter of what is described.
  float angle_rad = 0.0F;    ///< Its direction, from x towards y.
  float response = 0.0F;     ///< Strength; the unit is the extractor's own.
};

/// Keypoints with a descriptor each: either `length` floats compared by Euclidean distance, or 256 bits compared by
/// Hamming distance (then length is 0).
struct DescribedKeypoints {
  std::vector<Keypoint> keypoints;
  int length = 0;
  std::vector<float> floats;     ///< keypoints.size() * length, one keypoint after the other.
  std::vector<Descriptor> bits;  ///< One a keypoint, or none.

  std::size_t size() const { return keypoints.size(); }
  bool binary() const { return length == 0; }
};

enum class DescriptorKind {
  sift,  ///< Lowe 2004; 128 floats, by OpenCV.
  orb,   ///< Rublee et al. 2011; 256 bits, by OpenCV.
  surf,  ///< Bay et al. 2008; 64 floats, by dlib; only in a build with RASTRO_WITH_SURF.
};

/// "sift", "orb" or "surf"; Error for any other word, which came from `where`.
DescriptorKind descriptor_kind(std::string_view name, std::string_view where);

struct DescriptorExtractorOptions {
  int max_keypoints = 1500;      ///< The strongest are kept.
  double sift_contrast = 0.04;   ///< Of a keypoint, Lowe's threshold as OpenCV counts it; less gives more.
  double surf_threshold = 30.0;  ///< Least determinant of the Hessian, as dlib counts it; less gives more.
  int orb_fast_threshold = 12;   ///< Grey levels of the corner test; less gives more.
};

/// Finds and describes keypoints. Keypoints are strongest first (equal: upper, then left one first), so the result
/// depends on nothing but image and options. Not to be used by two threads at once.
class DescriptorExtractor {
 public:
  /// Error for SURF in a build without it, and for options out of range.
  static std::unique_ptr<DescriptorExtractor> create(DescriptorKind kind, const DescriptorExtractorOptions& options);
  virtual ~DescriptorExtractor() = default;
  /// An image smaller than 64 pixels either way has no keypoints.
  DescribedKeypoints extract(GreyView image);

 private:
  virtual DescribedKeypoints extract_unsorted(GreyView image) = 0;
  std::size_t max_keypoints_ = 0;
};

/// Whether this build has SURF.
bool has_surf();

}  // namespace rastro
