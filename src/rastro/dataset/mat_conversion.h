// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "rastro/dataset/image_file.h"

namespace rastro {

/// From OpenCV's picture (8 or 16 bit; grey, grey + alpha, BGR or BGRA) to grey and, where wanted, colour. Returns why
/// not, or "". Internal to the dataset module: the only header that shows OpenCV.
std::string convert(const cv::Mat& picture, bool want_colour, DecodedImage& image);

}  // namespace rastro
