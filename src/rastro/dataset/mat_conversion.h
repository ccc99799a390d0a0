// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "rastro/dataset/image_file.h"

namespace rastro {

/// From OpenCV's image (8 or 16 bit; gray, gray + alpha, BGR or BGRA) to gray and, where wanted, color. Returns why
/// not, or "". Internal to the dataset module: the only header that shows OpenCV.
std::string convert(const cv::Mat& mat, bool want_color, DecodedImage& image);

}  // namespace rastro
