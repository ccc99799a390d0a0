// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// A surface point as the depth and surface images of a generated recording have it.
struct RecordedSurfacePoint {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  std::uint32_t surface = 0;
};

/// How a point of the world is seen in a frame of a generated recording.
struct RecordedView {
  bool inside = false;                              ///< It projects into the image.
  bool visible = false;                             ///< And no nearer surface is in the way.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< Meaningless when not inside.
};

/// The ground truth that `rastro simulate` writes to mav0/truth, read back. Images are read when they are asked for and
/// the last few dozen are kept. Error, naming the file, for one that is missing or broken: when it is first needed. Not
/// for use by several threads at once.
class SurfaceGroundTruthReader {
 public:
  explicit SurfaceGroundTruthReader(const std::string& ground_truth_folder);
  ~SurfaceGroundTruthReader();
  SurfaceGroundTruthReader(SurfaceGroundTruthReader&&) noexcept;

  const Camera& camera() const { return camera_; }
  /// Of the camera (world_from_camera), one pose a frame.
  const Trajectory& poses() const { return poses_; }
  std::int64_t frame_count() const { return static_cast<std::int64_t>(poses_.size()); }

  /// Between pixel centers the surface at the nearest center is continued as a plane. nullopt outside the image and for
  /// frames outside the recording, and where nothing was met.
  std::optional<RecordedSurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const;
  /// The surface that a corner detected there belongs to: one at an occluding edge is a corner of the nearer surface,
  /// though its pixel may show what is behind. So the nearest surface of the 3x3 pixels around, placed on the pixel's
  /// own ray.
  std::optional<RecordedSurfacePoint> corner_surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const;
  /// A point counts as hidden when every pixel of the 3x3 around it shows something nearer by more than a hundredth.
  RecordedView view_of(std::int64_t frame, const Eigen::Vector3d& point_in_world) const;

 private:
  struct Images;
  const Images& images(std::int64_t frame) const;
  std::optional<RecordedSurfacePoint> surface_near(std::int64_t frame, const Eigen::Vector2d& pixel, int reach) const;

  std::string folder_;
  Camera camera_;
  double inverse_depth_step_ = 0.0;
  Trajectory poses_;
  mutable std::vector<std::unique_ptr<Images>> kept_;
};

/// Reads the ground truth of a recording: `path` is its folder, its mav0 or the ground truth folder itself. Error where
/// there is none.
SurfaceGroundTruthReader read_surface_ground_truth(const std::string& path);

}  // namespace rastro
