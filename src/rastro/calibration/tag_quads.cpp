// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/tag_quads.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "rastro/calibration/contrast_area.h"

namespace rastro {
namespace {

/// Between black and white of a tag, gray levels.
constexpr float least_contrast = 20.0F;
/// Images up to half as large are enlarged, so that the borders of small tags are wide enough to be made thinner.
constexpr int largest_side = 2000;

/// How dark shapes that touch are parted. The squares between the tags of a grid touch their corners: where two dark
/// corners meet the image is half bright, so that a darker threshold parts them, and what is left is made thinner.
struct Parting {
  double level;  ///< Threshold, from the darkest (0) to the brightest (1) of the pixels around.
  int radius;    ///< By which the shapes are made thinner, pixels.
};
constexpr Parting partings[] = {{0.35, 0}, {0.35, 1}, {0.5, 1}};

/// Corners farther out by `pixels` along both sides.
TagQuad grown(const TagQuad& quad, float pixels) {
  const cv::Point2f center = center_of(quad);
  TagQuad result;
  for (std::size_t k = 0; k < 4; ++k) {
    const cv::Point2f out = quad[k] - center;
    result[k] = quad[k] + out * (1.41421356F * pixels / std::max(1.0F, static_cast<float>(cv::norm(out))));
  }
  return result;
}

/// Four-sided outlines of the shapes in a mask, each larger by `radius` pixels.
std::vector<TagQuad> quads_of(const cv::Mat& mask, int radius) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  std::vector<TagQuad> quads;
  for (const auto& contour : contours) {
    if (contour.size() < 50) continue;
    std::vector<cv::Point> polygon;
    cv::approxPolyDP(contour, polygon, 0.05 * static_cast<double>(contour.size()), true);
    if (polygon.size() != 4 || !cv::isContourConvex(polygon)) continue;
    TagQuad quad;
    std::copy(polygon.begin(), polygon.end(), quad.begin());
    const cv::Point2f along = quad[1] - quad[0], across = quad[2] - quad[0];
    if (along.x * across.y - along.y * across.x < 0.0F) std::swap(quad[1], quad[3]);
    quads.push_back(grown(quad, static_cast<float>(radius)));
  }
  return quads;
}

/// Gray of the cells of a tag, row by row.
std::vector<float> cell_values(const cv::Mat& image, const TagQuad& quad, int cells) {
  constexpr double samples[][2] = {{0.5, 0.5}, {0.7, 0.5}, {0.3, 0.5}, {0.5, 0.7}, {0.5, 0.3}};
  const double side = 1.0 / cells;
  const cv::Matx33d homography = image_from_square(quad) * cv::Matx33d(side, 0, 0, 0, side, 0, 0, 0, 1);
  std::vector<float> values;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      float sum = 0.0F;
      for (const auto& [u, v] : samples) {
        const cv::Point2f at = mapped(homography, x + u, y + v);
        const int left = std::clamp(static_cast<int>(std::lround(at.x)), 0, image.cols - 1);
        const int top = std::clamp(static_cast<int>(std::lround(at.y)), 0, image.rows - 1);
        sum += static_cast<float>(image.at<std::uint8_t>(top, left));
      }
      values.push_back(sum / 5.0F);
    }
  return values;
}

}  // namespace

TagQuad turned(const TagQuad& quad, std::size_t turns) {
  return {quad[turns % 4], quad[(1 + turns) % 4], quad[(2 + turns) % 4], quad[(3 + turns) % 4]};
}

float shortest_side(const TagQuad& quad) {
  double shortest = 1e9;
  for (std::size_t k = 0; k < 4; ++k) shortest = std::min(shortest, cv::norm(quad[k] - quad[(k + 1) % 4]));
  return static_cast<float>(shortest);
}

float narrowest_width(const TagQuad& quad) {
  const cv::Point2f one = quad[2] - quad[0], other = quad[3] - quad[1];
  double longest = 1e-9;
  for (std::size_t k = 0; k < 4; ++k) longest = std::max(longest, cv::norm(quad[k] - quad[(k + 1) % 4]));
  return static_cast<float>(0.5 * std::abs(one.x * other.y - one.y * other.x) / longest);
}

cv::Point2f center_of(const TagQuad& quad) { return (quad[0] + quad[1] + quad[2] + quad[3]) * 0.25F; }

cv::Matx33d image_from_square(const TagQuad& quad) {
  const cv::Point2d a = quad[0], b = quad[1], c = quad[2], d = quad[3];
  const cv::Point2d right = b - c, down = d - c, sum = a - b + c - d;
  const double area = right.x * down.y - right.y * down.x;
  if (std::abs(area) < 1e-12) return cv::Matx33d::zeros();
  const double g = (sum.x * down.y - sum.y * down.x) / area, h = (right.x * sum.y - right.y * sum.x) / area;
  return {b.x - a.x + g * b.x, d.x - a.x + h * d.x, a.x, b.y - a.y + g * b.y, d.y - a.y + h * d.y, a.y, g, h, 1.0};
}

cv::Point2f mapped(const cv::Matx33d& homography, double x, double y) {
  const cv::Vec3d image = homography * cv::Vec3d(x, y, 1.0);
  if (!(std::abs(image[2]) > 1e-12)) return {-1e6F, -1e6F};
  return {static_cast<float>(image[0] / image[2]), static_cast<float>(image[1] / image[2])};
}

std::vector<TagQuad> dark_quads(const cv::Mat& image) {
  std::vector<TagQuad> result;
  const auto area = contrast_area(image, 2.0F, largest_side);
  if (!area) return result;
  double level_of_mask = -1.0;
  cv::Mat mask;
  for (const auto& [level, radius] : partings) {
    if (level != level_of_mask) mask = area->dark(level_of_mask = level);
    cv::Mat dark = mask;
    if (radius > 0) {
      dark.release();
      cv::erode(mask, dark, cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}));
    }
    for (TagQuad& quad : quads_of(dark, radius)) {
      for (cv::Point2f& corner : quad) corner = area->in_image(corner);
      result.push_back(quad);
    }
  }
  return result;
}

std::optional<ReadTag> read_tag(const cv::Mat& image, const TagQuad& quad, cv::aruco::Dictionary& dictionary,
                                int border_cells) {
  const int cells = dictionary.markerSize + 2 * border_cells;
  const std::vector<float> values = cell_values(image, quad, cells);
  std::vector<float> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t tenth = sorted.size() / 10;
  const float dark = sorted[tenth], bright = sorted[sorted.size() - 1 - tenth];
  if (bright - dark < least_contrast) return std::nullopt;
  cv::Mat bits(dictionary.markerSize, dictionary.markerSize, CV_8UC1);
  int wrong = 0;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const bool white = values[static_cast<std::size_t>(y * cells + x)] > 0.5F * (dark + bright);
      const int column = x - border_cells, row = y - border_cells;
      if (column < 0 || row < 0 || column >= bits.cols || row >= bits.rows) {
        wrong += white ? 1 : 0;
      } else {
        bits.at<std::uint8_t>(row, column) = white ? 1 : 0;
      }
    }
  int id = 0, rotation = 0;
  if (wrong > cells / 3 || !dictionary.identify(bits, id, rotation, 0.6)) return std::nullopt;
  return ReadTag{id, static_cast<std::size_t>(4 - rotation) % 4};
}

}  // namespace rastro
