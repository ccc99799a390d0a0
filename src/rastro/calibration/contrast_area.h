// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

namespace rastro {

/// The part of an image where dark and bright are close together, enlarged: where a board may be.
struct ContrastArea {
  cv::Mat image;               ///< Gray.
  cv::Mat darkest, brightest;  ///< Of the pixels around each, within 1/40 of the image's larger side.
  float scale = 1.0F;          ///< By which it is enlarged.
  cv::Point2f origin;          ///< Its upper left pixel in the image.

  /// Mask (255) of pixels that are darker than `level`, from the darkest (0) to the brightest (1) around. The lower it
  /// is, the less dark shapes join that touch with a corner: where two corners meet, the image is half bright.
  cv::Mat dark(double level) const;
  /// Position in the image of one in the area.
  cv::Point2f in_image(const cv::Point2f& in_area) const;
};

/// Enlarged by up to `largest_scale`, but to no more than `largest_side` pixels; nullopt where all is even.
std::optional<ContrastArea> contrast_area(const cv::Mat& image, float largest_scale, int largest_side);

}  // namespace rastro
