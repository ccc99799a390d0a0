// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/multiview/point_pairs.h"
#include "rastro/track/options.h"
#include "rastro/track/track_store.h"
#include "rastro/track/undistorted_camera.h"

namespace rastro {

/// Motion of the undistorted image since each of the last frames. The homographies are chained from frame to frame, so
/// they outlive the features they were estimated from, and each is refined with the features observed in both frames
/// while there are any. There are two layers, such as a scene and an object passing in front of it, each with its own
/// motion; features stay with the layer they moved with.
class MotionHistory {
 public:
  static constexpr int layers = 2;

  /// `options` must outlive it.
  explicit MotionHistory(const TrackOptions& options);

  /// Advances to frame `current`: `followed` are the features tracked into it from the previous frame; each gets its
  /// layer. If no motion can be estimated, all history is discarded.
  void advance(std::int64_t current, std::span<const Association> followed, TrackStore& store);

  struct Motion {
    std::int64_t frame = -1;
    std::int64_t refined_in = -1;
    Eigen::Matrix3d current_from_frame = Eigen::Matrix3d::Identity();
    PointPairs shared;          ///< The layer's features observed in both frames.
    double inlier_share = 0.0;  ///< Of `shared`; 0 with too few for a refinement.
  };

  /// A motion from one frame to the next, and the tracked features consistent with it.
  struct Step {
    Eigen::Matrix3d current_from_last = Eigen::Matrix3d::Identity();
    std::vector<char> takes_part;
  };

  /// The motion of a layer from frame `frame` to the current one; nullopt if unknown. Refined on first use.
  const Motion* since(std::int64_t frame, int layer, std::span<const Association> followed, const TrackStore& store);
  /// Rotation and scale of a track's surroundings since frame `frame`, in which it was observed, if they move with
  /// `layer`; nullopt if unknown or implausibly large.
  std::optional<Eigen::Matrix2f> rotated_since(std::int64_t frame, int layer, const Track& track,
                                               std::span<const Association> followed, const TrackStore& store);

 private:
  Motion& at(std::int64_t frame, int layer) {
    auto& motions = motions_[static_cast<std::size_t>(layer)];
    return motions[static_cast<std::size_t>(frame) % motions.size()];
  }
  static int layer_of_first(const std::vector<Step>& steps, std::span<const Association> followed,
                            const TrackStore& store);
  Eigen::Matrix3d guess_step(int layer, const Step& other, std::int64_t current, std::span<const Association> followed,
                             const TrackStore& store) const;
  void move(int layer, const Eigen::Matrix3d& step);
  void refine(Motion& motion, int layer, std::span<const Association> followed, const TrackStore& store) const;

  const TrackOptions& options_;
  std::int64_t current_ = -1;
  bool layers_differ_ = false;  ///< The layers had different motions when both were last observed.
  std::array<Eigen::Matrix3d, layers> last_step_{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  std::array<std::vector<Motion>, layers> motions_;
};

/// Maps a pixel by a homography between undistorted pixels.
std::optional<Eigen::Vector2d> moved_pixel(const Eigen::Matrix3d& homography, const Eigen::Vector2f& ideal,
                                           const UndistortedCamera& camera);

/// The derivative of such a homography: rotation and scale of the surroundings. nullopt if it mirrors, or stretches
/// to more than double or less than half.
std::optional<Eigen::Matrix2f> derivative_at(const Eigen::Matrix3d& homography, const Eigen::Vector2f& ideal);

}  // namespace rastro
