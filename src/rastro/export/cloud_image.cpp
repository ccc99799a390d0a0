// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/cloud_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "rastro/export/drawing.h"
#include "rastro/map/cloud/upright.h"

namespace rastro {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double longest_px = 1600.0, most_px_per_m = 200.0, margin_m = 0.3;
constexpr double above_cameras_m = 0.25;
constexpr double strays = 0.002;  ///< Share of points on each side that may lie outside the image.

// OpenCV order: blue, green, red.
const cv::Scalar path_color(200, 90, 0), start_color(0, 150, 0), end_color(0, 0, 220), bar_color(0, 0, 0);

/// The least and the greatest coordinate but for strays; none of no points.
std::vector<double> without_strays(const std::vector<Vector3d>& cloud, int axis) {
  if (cloud.empty()) return {};
  std::vector<double> values;
  values.reserve(cloud.size());
  for (const Vector3d& position : cloud) values.push_back(position[axis]);
  const auto skipped = static_cast<std::ptrdiff_t>(strays * static_cast<double>(values.size()));
  const auto low = values.begin() + skipped, high = values.end() - 1 - skipped;
  std::nth_element(values.begin(), low, values.end());
  const double lowest = *low;
  std::nth_element(values.begin(), high, values.end());
  return {lowest, *high};
}

class Sheet {
 public:
  /// All of the path and nearly all of the cloud; in a unit of its own, it fills the sheet.
  Sheet(const std::vector<Vector3d>& cloud, const std::vector<Vector3d>& path, bool metric) {
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double> values = without_strays(cloud, axis);
      for (const Vector3d& position : path) values.push_back(position[axis]);
      if (values.empty()) values.push_back(0.0);
      low_[axis] = *std::min_element(values.begin(), values.end());
      high_[axis] = *std::max_element(values.begin(), values.end());
    }
    constexpr double margin_share = 0.03, least_extent = 1e-9;
    const double extent = std::max(least_extent, (high_ - low_).maxCoeff());
    const double margin = metric ? margin_m : margin_share * extent;
    low_.array() -= margin, high_.array() += margin;
    scale_ = longest_px / (high_ - low_).maxCoeff();
    if (metric) scale_ = std::min(most_px_per_m, scale_);
    const Vector2d size = (high_ - low_) * scale_;
    image = cv::Mat(std::max(1, cvRound(size.y())), std::max(1, cvRound(size.x())), CV_8UC3, cv::Scalar::all(255));
  }

  Vector2d pixel(const Vector3d& position) const {
    return {(position.x() - low_.x()) * scale_, (high_.y() - position.y()) * scale_};
  }
  cv::Point whole(const Vector3d& position) const {
    const Vector2d at = pixel(position).cwiseMax(-1e6).cwiseMin(1e6);
    return {cvRound(at.x()), cvRound(at.y())};
  }
  double px_per_m() const { return scale_; }

  cv::Mat image;

 private:
  Vector2d low_, high_;
  double scale_ = 1.0;
};

void draw_points(Sheet& sheet, const std::vector<Vector3d>& positions, const std::vector<const CloudPoint*>& points,
                 double voxel_m) {
  cv::Mat heights(sheet.image.size(), CV_32F, cv::Scalar(-1e9));
  const int side = std::max(1, static_cast<int>(std::ceil(voxel_m * sheet.px_per_m())));
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const Vector3d& position = positions[k];
    const auto& color = points[k]->color;
    const cv::Point corner = sheet.whole(position) - cv::Point(side / 2, side / 2);
    for (int y = std::max(0, corner.y); y < std::min(heights.rows, corner.y + side); ++y) {
      for (int x = std::max(0, corner.x); x < std::min(heights.cols, corner.x + side); ++x) {
        const auto height = static_cast<float>(position.z());
        if (height <= heights.at<float>(y, x)) continue;
        heights.at<float>(y, x) = height;
        sheet.image.at<cv::Vec3b>(y, x) = {color[2], color[1], color[0]};
      }
    }
  }
}

void draw_path(Sheet& sheet, const std::vector<Vector3d>& path) {
  if (path.empty()) return;
  std::vector<cv::Point> vertices;
  for (const Vector3d& position : path) vertices.push_back(sheet.whole(position));
  cv::polylines(sheet.image, vertices, false, path_color, 2, cv::LINE_AA);
  for (const auto& [name, at, color] :
       {std::tuple{"end", vertices.back(), end_color}, std::tuple{"start", vertices.front(), start_color}}) {
    cv::circle(sheet.image, at, 5, color, cv::FILLED, cv::LINE_AA);
    drawing::put_text(sheet.image, name, {static_cast<float>(at.x) + 8.0F, static_cast<float>(at.y) - 6.0F},
                      drawing::white, 0.5);
  }
}

void draw_bar(Sheet& sheet, const std::string& unit) {
  constexpr double least_px = 20.0, most_px = 400.0;
  double length = 1.0;
  while (length * sheet.px_per_m() < least_px) length *= 10.0;
  while (unit != "m" && length * sheet.px_per_m() > most_px) length /= 10.0;
  const int y = sheet.image.rows - 12;
  cv::line(sheet.image, {10, y}, {10 + cvRound(length * sheet.px_per_m()), y}, bar_color, 3);
  drawing::put_text(sheet.image, fmt::format("{:g} {}", length, unit), {10.0F, static_cast<float>(y) - 8.0F},
                    drawing::white, 0.5);
}

}  // namespace

void write_cloud_image(const PointCloud& cloud, const Trajectory& trajectory, const std::string& file,
                       const std::string& unit) {
  const SE3 upright_from_world = find_upright(cloud, trajectory).upright_from_world;
  std::vector<Vector3d> path;
  double highest = trajectory.empty() ? 1e9 : -1e9;
  for (const StampedPose& pose : trajectory) {
    path.push_back(upright_from_world * pose.world_from_body.translation());
    highest = std::max(highest, path.back().z() + above_cameras_m);
  }
  std::vector<Vector3d> positions;
  std::vector<const CloudPoint*> points;
  for (const CloudPoint& point : cloud.points) {
    const Vector3d position = upright_from_world * point.position.cast<double>();
    if (position.z() > highest) continue;
    positions.push_back(position);
    points.push_back(&point);
  }
  Sheet sheet(positions, path, unit == "m");
  draw_points(sheet, positions, points, cloud.voxel_m);
  draw_path(sheet, path);
  draw_bar(sheet, unit);
  drawing::save(file, sheet.image);
}

}  // namespace rastro
