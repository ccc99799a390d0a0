// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "rastro/feature/features.h"
#include "rastro/image/image.h"

namespace rastro {

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
  Features extract(GreyView image);

 private:
  virtual Features extract_unsorted(GreyView image) = 0;
  std::size_t max_keypoints_ = 0;
};

/// Whether this build has SURF.
bool has_surf();

}  // namespace rastro
