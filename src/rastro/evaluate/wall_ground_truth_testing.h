// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <map>

#include "rastro/evaluate/surface_ground_truth.h"
#include "rastro/track/track_table.h"

namespace rastro {

/// A wall at 10 m with a board at 5 m that slides along in front of it, seen by a camera (f = 100 px, 200x100) that
/// moves 0.05 m to the right each frame: everything in closed form. The wall ends above row 10; there is sky.
class WallGroundTruth : public SurfaceGroundTruth {
 public:
  static constexpr double focal = 100.0, center_x = 100.0, center_y = 50.0, wall_z = 10.0, board_z = 5.0;
  static constexpr std::uint32_t wall = 1, board = 2;
  static constexpr double board_width = 2.0;

  explicit WallGroundTruth(std::int64_t frames) : frames_(frames) {}

  static double camera_x(std::int64_t frame) { return 0.05 * static_cast<double>(frame); }
  /// Left edge of the board in the world; it is in front of the image center in frames 5 to 9 or so.
  static double board_left(std::int64_t frame) { return -6.0 + 0.75 * static_cast<double>(frame); }

  /// Projection of a wall point, occluded or not.
  static Eigen::Vector2d wall_pixel(std::int64_t frame, double x, double y) {
    return {center_x + focal * (x - camera_x(frame)) / wall_z, center_y + focal * y / wall_z};
  }
  static bool covered(std::int64_t frame, const Eigen::Vector2d& pixel) {
    const double x = camera_x(frame) + (pixel.x() - center_x) * board_z / focal;
    return x >= board_left(frame) && x <= board_left(frame) + board_width;
  }
  static bool inside(const Eigen::Vector2d& pixel) {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= 199 && pixel.y() <= 99;
  }

  std::int64_t frame_count() const override { return frames_; }
  std::optional<SurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const override {
    if (!inside(pixel)) return std::nullopt;
    const bool on_board = covered(frame, pixel);
    if (!on_board && pixel.y() < 10) return std::nullopt;
    const double z = on_board ? board_z : wall_z;
    Eigen::Vector3d point(camera_x(frame) + (pixel.x() - center_x) * z / focal, (pixel.y() - center_y) * z / focal, z);
    // A point of the board is kept in the board's own frame, since it moves with the board.
    if (on_board) point.x() -= board_left(frame);
    return SurfacePoint{point, on_board ? board : wall};
  }
  ProjectedPoint project(std::int64_t frame, const SurfacePoint& point) const override {
    const bool on_board = point.surface == board;
    const double x = point.point_in_world.x() + (on_board ? board_left(frame) : 0.0) - camera_x(frame);
    const double scale = focal / point.point_in_world.z();
    const Eigen::Vector2d pixel(center_x + x * scale, center_y + point.point_in_world.y() * scale);
    if (!inside(pixel)) return {};
    const bool hidden = !on_board && covered(frame, pixel);
    return {hidden ? Visibility::occluded_by_surface : Visibility::visible, pixel};
  }

 private:
  std::int64_t frames_;
};

/// Builds a table by hand; features come out in ascending order of id, as from a tracker.
class TableBuilder {
 public:
  explicit TableBuilder(std::int64_t frames) : frames_(frames) {}

  TableBuilder& see(std::int64_t frame, std::int64_t id, const Eigen::Vector2d& pixel, TrackState state) {
    TrackedFeature feature;
    feature.id = id;
    feature.pixel = pixel.cast<float>();
    feature.state = state;
    seen_[frame].push_back(feature);
    return *this;
  }
  /// Observations of a wall point in frames first .. last, the first one in the given state, the others tracked.
  TableBuilder& follow(std::int64_t first, std::int64_t last, std::int64_t id, double x, double y, TrackState state) {
    for (std::int64_t k = first; k <= last; ++k)
      see(k, id, WallGroundTruth::wall_pixel(k, x, y), k == first ? state : TrackState::tracked);
    return *this;
  }
  TrackTable table() const {
    TrackTable result;
    for (std::int64_t k = 0; k < frames_; ++k) {
      TrackFrame frame;
      frame.index = k;
      frame.stamp = k * 50'000'000;
      if (const auto found = seen_.find(k); found != seen_.end()) frame.features = found->second;
      std::stable_sort(frame.features.begin(), frame.features.end(),
                       [](const TrackedFeature& a, const TrackedFeature& b) { return a.id < b.id; });
      result.frames.push_back(frame);
    }
    return result;
  }

 private:
  std::int64_t frames_;
  std::map<std::int64_t, std::vector<TrackedFeature>> seen_;
};

}  // namespace rastro
