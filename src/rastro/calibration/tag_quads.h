// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <opencv2/aruco.hpp>
#include <optional>
#include <vector>

namespace rastro {

/// Corners of a tag in an image, clockwise.
using TagQuad = std::array<cv::Point2f, 4>;

/// The same quad with another corner first.
TagQuad turned(const TagQuad& quad, std::size_t turns);
/// Pixels.
float shortest_side(const TagQuad& quad);
/// Of the strips between opposite sides; pixels.
float narrowest_width(const TagQuad& quad);
cv::Point2f center_of(const TagQuad& quad);

/// The homography of the unit square, (0, 0) to the first corner, (1, 0) to the second (Heckbert 1989, 2.2.3); zeros
/// for quads without area.
cv::Matx33d image_from_square(const TagQuad& quad);
/// Where a homography maps a point; far outside of every image where it maps it to infinity.
cv::Point2f mapped(const cv::Matx33d& homography, double x, double y);

/// Quads that are darker than what is around them: tags of a grid, among others. They come from several thresholds, so
/// that one tag may be there more than once. In images of up to 1000 pixels sides of 10 pixels are enough.
std::vector<TagQuad> dark_quads(const cv::Mat& image);

struct ReadTag {
  int id = 0;
  std::size_t turns = 0;  ///< turned(quad, turns) begins where the tag's drawing does.
};
/// The tag in a quad with a border of so many dark cells; nullopt for what is none.
std::optional<ReadTag> read_tag(const cv::Mat& image, const TagQuad& quad, cv::aruco::Dictionary& dictionary,
                                int border_cells);

}  // namespace rastro
