// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "rastro/calibration/board_detector.h"

namespace rastro {

/// By an integer factor, as the mean of the pixels: pixel (x, y) of the small image covers those from (x f, y f) on.
cv::Mat reduced_image(const cv::Mat& image, int factor);
/// Position in the full image of one in the reduced image.
inline cv::Point2f in_full_image(const cv::Point2f& small, int factor) {
  const cv::Point2f half(0.5F, 0.5F);
  return (small + half) * static_cast<float>(factor) - half;
}

/// A board with tags.
std::optional<DetectedBoard> detect_tags(const cv::Mat& image, const Board& board);

}  // namespace rastro
