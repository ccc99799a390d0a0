// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "rastro/image/image.h"
#include "rastro/track/track_frame.h"

// Included by the .cpp files of this folder only, so that OpenCV stays out of rastro's headers.
namespace rastro::drawing {

// OpenCV order: blue, green, red.
inline const cv::Scalar red(40, 40, 255);
inline const cv::Scalar green(60, 230, 60);
inline const cv::Scalar magenta(255, 60, 255);
inline const cv::Scalar white(255, 255, 255);

/// A color image of a gray image, enlarged by a whole factor until ids can be read in it.
struct Canvas {
  cv::Mat image;
  int scale = 1;
  cv::Point2f at(const Eigen::Vector2f& pixel) const;
};

/// How much an image of this width is enlarged.
int scale_for(int width);
Canvas canvas_of(GrayView image);

/// Text with a dark rim, kept inside the image.
void put_text(cv::Mat& image, const std::string& text, cv::Point2f lower_left, const cv::Scalar& color, double size);
/// A dark strip with one line of text in colors, put above the image.
struct Piece {
  std::string text;
  cv::Scalar color;
};
cv::Mat with_caption(const cv::Mat& image, const std::vector<Piece>& pieces);
/// The strip alone.
cv::Mat caption_strip(int width, const std::vector<Piece>& pieces);

/// The frame with positions in red and ids in green, and a caption with its counts.
cv::Mat overlay(const TrackFrame& frame, GrayView image);

/// As the extension says: .png, or .jpg for a picture that is mostly a photograph. Error naming the file when the image
/// cannot be written.
void save(const std::string& path, const cv::Mat& image);

}  // namespace rastro::drawing
