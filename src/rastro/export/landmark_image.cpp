// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/landmark_image.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/export/trajectory_plot_pen.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int longest_px = 1200, margin_px = 40, caption_px = 30;
constexpr int least_width_px = 600, least_height_px = 300;  // The caption fits in.
constexpr double strays = 0.02;  ///< Share of the landmarks on each side that may lie outside the sheet.
constexpr PlotColor gray{190, 190, 190}, light_green{190, 230, 190}, green{60, 150, 60};
constexpr PlotColor red{220, 40, 40}, blue{40, 70, 220}, dark{30, 30, 30};

/// Rows: right, up on the sheet, as directions of the world.
Eigen::Matrix<double, 2, 3> sheet_axes(const Map& map) {
  Vector3d up = Vector3d::Zero(), ahead = Vector3d::UnitZ();
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.submap == 0) up -= keyframe.world_from_camera.rotation() * Vector3d::UnitY();
  if (!(up.norm() > 1e-6)) up = -Vector3d::UnitY();
  up.normalize();
  if (!map.keyframes.empty()) ahead = map.keyframes.front().world_from_camera.rotation() * Vector3d::UnitZ();
  ahead -= ahead.dot(up) * up;
  if (ahead.norm() < 1e-3) ahead = up.unitOrthogonal();
  ahead.normalize();
  Eigen::Matrix<double, 2, 3> axes;
  axes << ahead.cross(up).transpose(), ahead.transpose();
  return axes;
}

/// What is drawn, in sheet directions and the map's unit.
struct Content {
  std::vector<Vector2d> landmarks, keyframes, trajectory;
  std::size_t landmark_count = 0;  ///< Of all submaps.
};

Content content_from_above(const Map& map) {
  const auto axes = sheet_axes(map);
  Content content;
  if (const auto layer = map.layer<LandmarkLayer>()) {
    content.landmark_count = layer->landmarks.size();
    for (const Landmark& landmark : layer->landmarks)
      if (submap_of(map, landmark) == 0) content.landmarks.emplace_back(axes * landmark.position);
  }
  for (const Keyframe& keyframe : map.keyframes)
    content.keyframes.emplace_back(axes * keyframe.world_from_camera.translation());
  for (const StampedPose& pose : trajectory_of(map))
    content.trajectory.emplace_back(axes * pose.world_from_body.translation());
  return content;
}

/// Brings positions to pixels.
class Sheet {
 public:
  Sheet(const Map& map, const Content& content) {
    Vector2d size;
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double> values;
      for (const Vector2d& position : content.landmarks) values.push_back(position[axis]);
      std::sort(values.begin(), values.end());
      const auto skipped = static_cast<std::size_t>(strays * static_cast<double>(values.size()));
      values = values.empty() ? std::vector<double>{} : std::vector<double>{values[skipped], values.rbegin()[skipped]};
      for (std::size_t k = 0; k < map.keyframes.size(); ++k)
        if (map.keyframes[k].submap == 0) values.push_back(content.keyframes[k][axis]);
      for (const Vector2d& position : content.trajectory) values.push_back(position[axis]);
      if (values.empty()) values.push_back(0.0);
      low_[axis] = *std::min_element(values.begin(), values.end());
      size[axis] = *std::max_element(values.begin(), values.end()) - low_[axis];
    }
    if (!size.allFinite() || !(size.maxCoeff() > 0.0)) size = Vector2d::Ones();
    scale_ = (longest_px - 2 * margin_px) / size.maxCoeff();
    const auto side = [&](int axis, int least) {
      return std::clamp(static_cast<int>(std::lround(size[axis] * scale_)) + 2 * margin_px, least, longest_px);
    };
    width = side(0, least_width_px), height = side(1, least_height_px) + caption_px;
    left_ = 0.5 * (width - size.x() * scale_);
  }

  Vector2d pixel(const Vector2d& position) const {
    return {left_ + (position.x() - low_.x()) * scale_, height - margin_px - (position.y() - low_.y()) * scale_};
  }
  bool holds(const Vector2d& at) const {
    return at.x() >= 0.0 && at.y() >= caption_px && at.x() < width && at.y() < height;
  }
  double px_per_unit() const { return scale_; }

  int width = 0, height = 0;

 private:
  Vector2d low_ = Vector2d::Zero();
  double left_ = 0.0;  ///< Pixels, of the leftmost position.
  double scale_ = 1.0;
};

class Drawing {
 public:
  Drawing(const Map& map, PlotPen& pen, const Sheet& sheet, const Content& content)
      : map_(map), pen_(pen), sheet_(sheet), content_(content) {}

  void draw(int covisible) {
    for (const Vector2d& position : content_.landmarks) dot(position, 0.6, gray);
    for (const Covisibility& pair : covisibility_graph(map_, covisible))
      edge(pair.first, pair.second, light_green, 1.0);
    const auto essential = essential_graph(map_);
    for (const EssentialEdge& each : essential)
      if (each.kind != EssentialKind::constraint) edge(each.first, each.second, green, 1.0);
    for (const EssentialEdge& each : essential)
      if (each.kind == EssentialKind::constraint) edge(each.first, each.second, red, 2.0);
    draw_trajectory();
    for (std::size_t k = 0; k < map_.keyframes.size(); ++k)
      if (map_.keyframes[k].submap == 0) dot(content_.keyframes[k], 2.0, blue);
    draw_caption(covisible);
  }

 private:
  void dot(const Vector2d& position, double radius, PlotColor color) {
    const Vector2d at = sheet_.pixel(position);
    if (!sheet_.holds(at)) return;
    pen_.line({at - Vector2d(radius, 0.0), at + Vector2d(radius, 0.0)}, color, 2.0 * radius);
  }

  void edge(std::size_t a, std::size_t b, PlotColor color, double width) {
    if (map_.keyframes[a].submap != 0 || map_.keyframes[b].submap != 0) return;
    pen_.line({sheet_.pixel(content_.keyframes[a]), sheet_.pixel(content_.keyframes[b])}, color, width);
  }

  void draw_trajectory() {
    if (content_.trajectory.empty()) return;
    std::vector<Vector2d> vertices;
    for (const Vector2d& position : content_.trajectory) vertices.push_back(sheet_.pixel(position));
    pen_.line(vertices, dark, 1.5);
    const Vector2d beside(6.0, -6.0);
    pen_.text("S", vertices.front() + beside, TextAnchor::left, 16.0, dark);
    pen_.text("E", vertices.back() + beside, TextAnchor::left, 16.0, dark);
  }

  void draw_caption(int covisible) {
    double length = 1.0;
    while (length * sheet_.px_per_unit() < 30.0) length *= 10.0;
    while (length * sheet_.px_per_unit() > 300.0) length /= 10.0;
    pen_.line({{10.0, 22.0}, {10.0 + length * sheet_.px_per_unit(), 22.0}}, dark, 3.0);
    const char* unit = scale_of(map_).metric ? "m" : length == 1.0 ? "map unit" : "map units";
    pen_.text(fmt::format("{:g} {}   {} keyframes, {} landmarks, covisible: {} shared", length, unit,
                          map_.keyframes.size(), content_.landmark_count, covisible),
              {10.0, 16.0}, TextAnchor::left, 13.0, dark);
  }

  const Map& map_;
  PlotPen& pen_;
  const Sheet& sheet_;
  const Content& content_;
};

}  // namespace

void write_landmark_image(const Map& map, const std::string& file, int covisible) {
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension != ".svg" && extension != ".png")
    throw Error("an image is a .svg or a .png file", file, "give --out FILE.svg or FILE.png");
  const Content content = content_from_above(map);
  const Sheet sheet(map, content);
  const auto pen = extension == ".svg" ? svg_pen(sheet.width, sheet.height) : png_pen(sheet.width, sheet.height);
  Drawing(map, *pen, sheet, content).draw(covisible);
  pen->save(file);
}

}  // namespace rastro
