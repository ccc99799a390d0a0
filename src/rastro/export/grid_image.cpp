// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/grid_image.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "rastro/export/drawing.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

using Eigen::Vector2d;

constexpr double longest_px = 1600.0;
constexpr double most_px_per_m = 200.0;
constexpr double margin_m = 0.5;
constexpr double chi_square_95 = 5.991;  ///< Two degrees of freedom.
constexpr int fraction_bits = 4;
constexpr std::uint8_t unknown_gray = 215;

// OpenCV order: blue, green, red.
const cv::Scalar path_color(200, 90, 0), keyframe_color(120, 40, 0), loop_color(0, 140, 255),
    landmark_color(190, 0, 190), position_color(220, 170, 60), start_color(0, 150, 0), end_color(0, 0, 220),
    bar_color(0, 0, 0);

/// What of the world is in the image.
struct View {
  Vector2d lower = Vector2d::Zero(), upper = Vector2d::Zero();
  double px_per_m = most_px_per_m;
  cv::Size size;

  Vector2d pixel(const Vector2d& world) const {
    return {(world.x() - lower.x()) * px_per_m, (upper.y() - world.y()) * px_per_m};
  }
  cv::Point fine(const Vector2d& world) const {
    const Vector2d at = pixel(world) * (1 << fraction_bits);
    return {cvRound(at.x()), cvRound(at.y())};
  }
  cv::Point whole(const Vector2d& world) const { return {cvRound(pixel(world).x()), cvRound(pixel(world).y())}; }
};

class Bounds {
 public:
  void add(const Vector2d& point) {
    if (!point.allFinite()) return;
    lower_ = any_ ? Vector2d(lower_.cwiseMin(point)) : point;
    upper_ = any_ ? Vector2d(upper_.cwiseMax(point)) : point;
    any_ = true;
  }

  View view() const {
    View view;
    view.lower = lower_ - Vector2d::Constant(margin_m);
    view.upper = upper_ + Vector2d::Constant(margin_m);
    const Vector2d extent = view.upper - view.lower;
    view.px_per_m = std::min(most_px_per_m, longest_px / extent.maxCoeff());
    view.size = {std::max(1, static_cast<int>(std::lround(extent.x() * view.px_per_m))),
                 std::max(1, static_cast<int>(std::lround(extent.y() * view.px_per_m)))};
    return view;
  }

 private:
  Vector2d lower_ = Vector2d::Zero(), upper_ = Vector2d::Zero();
  bool any_ = false;
};

/// Of all that is known; unknown cells around it are omitted.
View view_of(const MapImage& image) {
  Bounds bounds;
  if (image.grid) {
    const OccupancyGrid& grid = *image.grid;
    grid.percent.for_each([&](int x, int y, std::int8_t percent) {
      if (percent != OccupancyGrid::unknown) bounds.add(grid.center_of(x, y));
    });
  }
  for (const Vector2d& position : image.path) bounds.add(position);
  for (const PositionEllipse& landmark : image.landmarks) bounds.add(landmark.center);
  return bounds.view();
}

std::uint8_t gray_of(std::int8_t percent) {
  if (percent == OccupancyGrid::unknown) return unknown_gray;
  return static_cast<std::uint8_t>(255 - static_cast<int>(std::lround(2.55 * percent)));
}

class Drawing {
 public:
  explicit Drawing(const MapImage& image)
      : image_(image), view_(view_of(image)), sheet_(view_.size, CV_8UC3, cv::Scalar::all(255)) {}

  cv::Mat draw() {
    if (image_.grid) draw_grid(*image_.grid);
    for (const PositionEllipse& position : image_.positions) draw_ellipse(position, position_color);
    draw_loops();
    draw_line(image_.path, path_color, 2);
    for (const Vector2d& position : image_.keyframes) draw_dot(position, keyframe_color, 2);
    for (const PositionEllipse& landmark : image_.landmarks) draw_landmark(landmark);
    draw_ends();
    draw_bar();
    return sheet_;
  }

 private:
  void draw_grid(const OccupancyGrid& grid) {
    for (int row = 0; row < sheet_.rows; ++row) {
      std::vector<std::int8_t> cells;  // Of the row of the grid that this row of pixels shows.
      for (int column = 0; column < sheet_.cols; ++column) {
        const Vector2d world = view_.lower + Vector2d(column + 0.5, sheet_.rows - row - 0.5) / view_.px_per_m;
        const Eigen::Vector2i cell = grid.cell_of(world);
        const bool inside = grid.holds(cell.x(), cell.y());
        if (inside && cells.empty()) cells = grid.row(cell.y());
        draw_cell(row, column, inside ? cells[static_cast<std::size_t>(cell.x())] : OccupancyGrid::unknown);
      }
    }
    if (grid.cell_m * view_.px_per_m < 1.0) keep_walls(grid);
  }

  void draw_cell(int row, int column, std::int8_t percent) {
    const std::uint8_t gray = gray_of(percent);
    sheet_.at<cv::Vec3b>(row, column) = {gray, gray, gray};
  }

  /// Where hundreds lie beside each other, one stands for all; walls stay on top.
  void draw_loops() {
    constexpr double min_distance_px = 100.0, opacity = 0.6;
    std::vector<std::pair<Vector2d, Vector2d>> drawn;
    const cv::Mat before = sheet_.clone();
    for (const auto& [from, to] : image_.loops) {
      const Vector2d a = view_.pixel(from), b = view_.pixel(to);
      const bool near_another = std::any_of(drawn.begin(), drawn.end(), [&, first = a, second = b](const auto& other) {
        return (other.first - first).norm() < min_distance_px && (other.second - second).norm() < min_distance_px;
      });
      if (near_another) continue;
      drawn.emplace_back(a, b);
      draw_line({from, to}, loop_color, 1);
    }
    if (drawn.empty()) return;
    cv::addWeighted(sheet_, opacity, before, 1.0 - opacity, 0.0, sheet_);
    if (image_.grid) draw_walls(before);
  }

  /// As they were, over what has been drawn since.
  void draw_walls(const cv::Mat& before) {
    constexpr std::uint8_t dark = 100;
    for (int y = 0; y < sheet_.rows; ++y)
      for (int x = 0; x < sheet_.cols; ++x)
        if (const cv::Vec3b& pixel = before.at<cv::Vec3b>(y, x); pixel[0] == pixel[2] && pixel[0] < dark)
          sheet_.at<cv::Vec3b>(y, x) = pixel;
  }

  /// Cells smaller than a pixel: a thin wall between two samples would vanish.
  void keep_walls(const OccupancyGrid& grid) {
    grid.percent.for_each([&](int x, int y, std::int8_t percent) {
      if (percent <= 50) return;
      const Vector2d at = view_.pixel(grid.center_of(x, y));
      const int column = std::clamp(static_cast<int>(at.x()), 0, sheet_.cols - 1);
      const int row = std::clamp(static_cast<int>(at.y()), 0, sheet_.rows - 1);
      draw_cell(row, column, percent);
    });
  }

  void draw_line(const std::vector<Vector2d>& points, const cv::Scalar& color, int width) {
    std::vector<cv::Point> vertices;
    for (const Vector2d& point : points)
      if (point.allFinite()) vertices.push_back(view_.fine(point));
    if (!vertices.empty()) cv::polylines(sheet_, vertices, false, color, width, cv::LINE_AA, fraction_bits);
  }

  void draw_dot(const Vector2d& position, const cv::Scalar& color, int radius) {
    if (!position.allFinite()) return;
    cv::circle(sheet_, view_.fine(position), radius << fraction_bits, color, cv::FILLED, cv::LINE_AA, fraction_bits);
  }

  void draw_ellipse(const PositionEllipse& ellipse, const cv::Scalar& color) {
    if (!ellipse.center.allFinite() || !ellipse.covariance.allFinite()) return;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(ellipse.covariance);
    const Vector2d lengths = (chi_square_95 * axes.eigenvalues().cwiseMax(0.0)).cwiseSqrt();
    // Not known at all: an ellipse larger than the image says nothing.
    if (lengths.maxCoeff() * view_.px_per_m > 2.0 * longest_px) return;
    std::vector<Vector2d> rim;
    constexpr int sides = 36;
    for (int k = 0; k <= sides; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / sides;
      const Vector2d on_circle(std::cos(angle), std::sin(angle));
      rim.push_back(ellipse.center + axes.eigenvectors() * lengths.cwiseProduct(on_circle));
    }
    draw_line(rim, color, 1);
  }

  void draw_landmark(const PositionEllipse& landmark) {
    if (!landmark.center.allFinite()) return;
    cv::drawMarker(sheet_, view_.whole(landmark.center), landmark_color, cv::MARKER_CROSS, 9, 2, cv::LINE_AA);
    draw_ellipse(landmark, landmark_color);
  }

  void draw_ends() {
    if (image_.path.empty()) return;
    mark("end", image_.path.back(), end_color, Vector2d(8.0, 16.0));
    mark("start", image_.path.front(), start_color, Vector2d(8.0, -6.0));
  }

  void mark(const std::string& name, const Vector2d& position, const cv::Scalar& color, const Vector2d& beside) {
    if (!position.allFinite()) return;
    draw_dot(position, color, 5);
    const Vector2d at = view_.pixel(position) + beside;
    drawing::put_text(sheet_, name, {static_cast<float>(at.x()), static_cast<float>(at.y())}, drawing::white, 0.5);
  }

  void draw_bar() {
    double meters = 1.0;
    while (meters * view_.px_per_m < 20.0) meters *= 10.0;
    const cv::Point left(10, sheet_.rows - 12), right(10 + cvRound(meters * view_.px_per_m), sheet_.rows - 12);
    cv::line(sheet_, left, right, bar_color, 3);
    drawing::put_text(sheet_, fmt::format("{:g} m", meters),
                      {static_cast<float>(left.x), static_cast<float>(left.y) - 8.0F}, drawing::white, 0.5);
  }

  const MapImage& image_;
  View view_;
  cv::Mat sheet_;
};

/// A loop closure between keyframes of a nearly straight path connects neighbors: no loop to be drawn.
constexpr double shortest_detour = 2.0;

/// Of the path through the keyframes, up to each.
std::vector<double> path_lengths(const Map& map) {
  std::vector<double> lengths(map.keyframes.size(), 0.0);
  for (std::size_t k = 1; k < lengths.size(); ++k)
    lengths[k] = lengths[k - 1] + (map.keyframes[k].world_from_camera.translation() -
                                   map.keyframes[k - 1].world_from_camera.translation())
                                      .norm();
  return lengths;
}

}  // namespace

MapImage map_image(const Map& map, std::shared_ptr<const OccupancyGrid> grid, const Trajectory& trajectory) {
  MapImage image;
  image.grid = std::move(grid);
  const auto in_plane = [](const SE3& pose) { return Vector2d(pose.translation().head<2>()); };
  for (const StampedPose& pose : trajectory) image.path.push_back(in_plane(pose.world_from_body));
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.submap == 0) image.keyframes.push_back(in_plane(keyframe.world_from_camera));
  const std::vector<double> path = path_lengths(map);
  for (const Constraint& constraint : map.constraints) {
    if (constraint.kind == ConstraintKind::odometry || constraint.kind == ConstraintKind::proximity) continue;
    const auto from = map.index_of(constraint.from), to = map.index_of(constraint.to);
    if (!from || !to || map.keyframes[*from].submap != 0 || map.keyframes[*to].submap != 0) continue;
    const Vector2d a = in_plane(map.keyframes[*from].world_from_camera);
    const Vector2d b = in_plane(map.keyframes[*to].world_from_camera);
    if (std::abs(path[*to] - path[*from]) < shortest_detour * (a - b).norm()) continue;
    image.loops.emplace_back(a, b);
  }
  if (const auto layer = map.layer<LandmarkLayer>(); layer && layer->estimates.size() == layer->landmarks.size())
    for (std::size_t k = 0; k < layer->landmarks.size(); ++k)
      image.landmarks.push_back(
          {layer->landmarks[k].position.head<2>(), layer->estimates[k].covariance.topLeftCorner<2, 2>()});
  return image;
}

void write_map_image(const MapImage& image, const std::string& file) { drawing::save(file, Drawing(image).draw()); }

}  // namespace rastro
