// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/grid_picture.h"

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
constexpr std::uint8_t unknown_grey = 215;

// OpenCV order: blue, green, red.
const cv::Scalar path_colour(200, 90, 0), keyframe_colour(120, 40, 0), loop_colour(0, 140, 255),
    landmark_colour(190, 0, 190), place_colour(220, 170, 60), start_colour(0, 150, 0), end_colour(0, 0, 220),
    bar_colour(0, 0, 0);

/// What of the world is in the picture.
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

/// Of all that is known; unknown cells around it are left away.
View view_of(const MapPicture& picture) {
  Bounds bounds;
  if (picture.grid) {
    const OccupancyGrid& grid = *picture.grid;
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < grid.width; ++x)
        if (grid.at(x, y) != OccupancyGrid::unknown) bounds.add(grid.centre_of(x, y));
  }
  for (const Vector2d& place : picture.path) bounds.add(place);
  for (const PlaceEllipse& landmark : picture.landmarks) bounds.add(landmark.centre);
  return bounds.view();
}

std::uint8_t grey_of(const OccupancyGrid& grid, const Vector2d& world) {
  const Eigen::Vector2i cell = grid.cell_of(world);
  if (!grid.holds(cell.x(), cell.y())) return unknown_grey;
  const std::int8_t percent = grid.at(cell.x(), cell.y());
  if (percent == OccupancyGrid::unknown) return unknown_grey;
  return static_cast<std::uint8_t>(255 - static_cast<int>(std::lround(2.55 * percent)));
}

class Drawing {
 public:
  explicit Drawing(const MapPicture& picture)
      : picture_(picture), view_(view_of(picture)), sheet_(view_.size, CV_8UC3, cv::Scalar::all(255)) {}

  cv::Mat draw() {
    if (picture_.grid) draw_grid(*picture_.grid);
    for (const PlaceEllipse& place : picture_.places) draw_ellipse(place, place_colour);
    for (const auto& [from, to] : picture_.loops) draw_line({from, to}, loop_colour, 1);
    draw_line(picture_.path, path_colour, 2);
    for (const Vector2d& place : picture_.keyframes) draw_dot(place, keyframe_colour, 2);
    for (const PlaceEllipse& landmark : picture_.landmarks) draw_landmark(landmark);
    draw_ends();
    draw_bar();
    return sheet_;
  }

 private:
  void draw_grid(const OccupancyGrid& grid) {
    for (int row = 0; row < sheet_.rows; ++row) {
      for (int column = 0; column < sheet_.cols; ++column) {
        const Vector2d world = view_.lower + Vector2d(column + 0.5, sheet_.rows - row - 0.5) / view_.px_per_m;
        const std::uint8_t grey = grey_of(grid, world);
        sheet_.at<cv::Vec3b>(row, column) = {grey, grey, grey};
      }
    }
    if (grid.cell_m * view_.px_per_m < 1.0) keep_walls(grid);
  }

  /// Cells smaller than a pixel: a thin wall between two samples would vanish.
  void keep_walls(const OccupancyGrid& grid) {
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        if (grid.at(x, y) <= 50) continue;
        const Vector2d at = view_.pixel(grid.centre_of(x, y));
        const int column = std::clamp(static_cast<int>(at.x()), 0, sheet_.cols - 1);
        const int row = std::clamp(static_cast<int>(at.y()), 0, sheet_.rows - 1);
        const std::uint8_t grey = grey_of(grid, grid.centre_of(x, y));
        sheet_.at<cv::Vec3b>(row, column) = {grey, grey, grey};
      }
    }
  }

  void draw_line(const std::vector<Vector2d>& places, const cv::Scalar& colour, int width) {
    std::vector<cv::Point> corners;
    for (const Vector2d& place : places)
      if (place.allFinite()) corners.push_back(view_.fine(place));
    if (!corners.empty()) cv::polylines(sheet_, corners, false, colour, width, cv::LINE_AA, fraction_bits);
  }

  void draw_dot(const Vector2d& place, const cv::Scalar& colour, int radius) {
    if (!place.allFinite()) return;
    cv::circle(sheet_, view_.fine(place), radius << fraction_bits, colour, cv::FILLED, cv::LINE_AA, fraction_bits);
  }

  void draw_ellipse(const PlaceEllipse& ellipse, const cv::Scalar& colour) {
    if (!ellipse.centre.allFinite() || !ellipse.covariance.allFinite()) return;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(ellipse.covariance);
    const Vector2d lengths = (chi_square_95 * axes.eigenvalues().cwiseMax(0.0)).cwiseSqrt();
    // Not known at all: an ellipse larger than the picture says nothing.
    if (lengths.maxCoeff() * view_.px_per_m > 2.0 * longest_px) return;
    std::vector<Vector2d> rim;
    constexpr int corners = 36;
    for (int k = 0; k <= corners; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / corners;
      const Vector2d on_circle(std::cos(angle), std::sin(angle));
      rim.push_back(ellipse.centre + axes.eigenvectors() * lengths.cwiseProduct(on_circle));
    }
    draw_line(rim, colour, 1);
  }

  void draw_landmark(const PlaceEllipse& landmark) {
    if (!landmark.centre.allFinite()) return;
    cv::drawMarker(sheet_, view_.whole(landmark.centre), landmark_colour, cv::MARKER_CROSS, 9, 2, cv::LINE_AA);
    draw_ellipse(landmark, landmark_colour);
  }

  void draw_ends() {
    if (picture_.path.empty()) return;
    mark("end", picture_.path.back(), end_colour, Vector2d(8.0, 16.0));
    mark("start", picture_.path.front(), start_colour, Vector2d(8.0, -6.0));
  }

  void mark(const std::string& name, const Vector2d& place, const cv::Scalar& colour, const Vector2d& beside) {
    if (!place.allFinite()) return;
    draw_dot(place, colour, 5);
    const Vector2d at = view_.pixel(place) + beside;
    drawing::put_text(sheet_, name, {static_cast<float>(at.x()), static_cast<float>(at.y())}, drawing::white, 0.5);
  }

  void draw_bar() {
    double metres = 1.0;
    while (metres * view_.px_per_m < 20.0) metres *= 10.0;
    const cv::Point left(10, sheet_.rows - 12), right(10 + cvRound(metres * view_.px_per_m), sheet_.rows - 12);
    cv::line(sheet_, left, right, bar_colour, 3);
    drawing::put_text(sheet_, fmt::format("{:g} m", metres),
                      {static_cast<float>(left.x), static_cast<float>(left.y) - 8.0F}, drawing::white, 0.5);
  }

  const MapPicture& picture_;
  View view_;
  cv::Mat sheet_;
};

}  // namespace

MapPicture map_picture(const Map& map, std::shared_ptr<const OccupancyGrid> grid, const Trajectory& trajectory) {
  MapPicture picture;
  picture.grid = std::move(grid);
  const auto in_plane = [](const SE3& pose) { return Vector2d(pose.translation().head<2>()); };
  for (const StampedPose& pose : trajectory) picture.path.push_back(in_plane(pose.world_from_body));
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.submap == 0) picture.keyframes.push_back(in_plane(keyframe.world_from_camera));
  for (const Constraint& constraint : map.constraints) {
    if (constraint.kind == ConstraintKind::odometry || constraint.kind == ConstraintKind::proximity) continue;
    const Keyframe *from = map.find(constraint.from), *to = map.find(constraint.to);
    if (!from || !to || from->submap != 0 || to->submap != 0) continue;
    picture.loops.emplace_back(in_plane(from->world_from_camera), in_plane(to->world_from_camera));
  }
  if (const auto layer = map.layer<LandmarkLayer>(); layer && layer->estimates.size() == layer->landmarks.size())
    for (std::size_t k = 0; k < layer->landmarks.size(); ++k)
      picture.landmarks.push_back(
          {layer->landmarks[k].position.head<2>(), layer->estimates[k].covariance.topLeftCorner<2, 2>()});
  return picture;
}

void write_map_picture(const MapPicture& picture, const std::string& file) {
  drawing::save(file, Drawing(picture).draw());
}

}  // namespace rastro
