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

/// "sift", "orb" or "surf"; throws Error naming `where` for any other word.
DescriptorKind descriptor_kind(std::string_view name, std::string_view where);

struct DescriptorExtractorOptions {
  int max_keypoints = 1500;      ///< The strongest are kept.
  double sift_contrast = 0.04;   ///< Lowe's contrast threshold in OpenCV's unit; lower gives more.
  double surf_threshold = 30.0;  ///< Minimum determinant of the Hessian in dlib's unit; lower gives more.
  int orb_fast_threshold = 12;   ///< Intensity threshold of the corner test; lower gives more.
};

/// Detects and describes keypoints. Keypoints are strongest first (equal: upper, then left one first), so the result
/// depends only on image and options. Not thread-safe.
class DescriptorExtractor {
 public:
  /// Throws Error for SURF in a build without it, and for options out of range.
  static std::unique_ptr<DescriptorExtractor> create(DescriptorKind kind, const DescriptorExtractorOptions& options);
  virtual ~DescriptorExtractor() = default;
  /// An image smaller than 64 pixels in width or height has no keypoints.
  Features extract(GrayView image);

 private:
  virtual Features extract_unsorted(GrayView image) = 0;
  std::size_t max_keypoints_ = 0;
};

/// Whether this build has SURF.
bool has_surf();

}  // namespace rastro
