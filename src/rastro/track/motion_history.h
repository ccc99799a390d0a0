// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/multiview/point_pairs.h"
#include "rastro/track/ideal_camera.h"
#include "rastro/track/options.h"
#include "rastro/track/track_store.h"

namespace rastro {

/// How the image, free of distortion, moved since each of the last frames: homographies chained from frame to frame, so
/// that they outlive the features they were found from, and each refined with the features seen in both frames as long
/// as there are any. There are two layers, such as a scene and what passes in front of it, each with a motion of its
/// own; features stay with the layer they moved with.
class MotionHistory {
 public:
  static constexpr int layers = 2;

  /// `options` must outlive it.
  explicit MotionHistory(const TrackOptions& options);

  /// Goes on to frame `current`: `followed` are the features followed into it from the frame before; each gets its
  /// layer. Where no motion is known, all that went before is forgotten.
  void advance(std::int64_t current, std::span<const Association> followed, TrackStore& store);

  struct Motion {
    std::int64_t frame = -1;
    std::int64_t refined_in = -1;
    Eigen::Matrix3d current_from_frame = Eigen::Matrix3d::Identity();
    PointPairs shared;          ///< What of the layer is seen in both frames.
    double inlier_share = 0.0;  ///< Of what is shared; 0 where too few for a refinement.
  };

  /// A motion from one frame to the next, and which of the followed features take part.
  struct Step {
    Eigen::Matrix3d current_from_last = Eigen::Matrix3d::Identity();
    std::vector<char> takes_part;
  };

  /// The motion of a layer from frame `frame` to the current one; null when not known. Refined when first asked for.
  const Motion* since(std::int64_t frame, int layer, std::span<const Association> followed, const TrackStore& store);
  /// How the surroundings of a track's place in frame `frame`, where it was seen, turned and stretched since, if they
  /// move with `layer`; nullopt when not known or unlikely much.
  std::optional<Eigen::Matrix2f> turned_since(std::int64_t frame, int layer, const Track& track,
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
  bool apart_ = false;  ///< The layers moved otherwise when both were last seen.
  std::array<Eigen::Matrix3d, layers> last_step_{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  std::array<std::vector<Motion>, layers> motions_;
};

/// Where a homography between pixels free of distortion takes a pixel.
std::optional<Eigen::Vector2d> moved_pixel(const Eigen::Matrix3d& homography, const Eigen::Vector2f& ideal,
                                           const IdealCamera& camera);

/// The derivative of such a homography: how the surroundings turn and stretch. nullopt where they would be mirrored, or
/// stretched or shrunk to more than double or less than half.
std::optional<Eigen::Matrix2f> derivative_at(const Eigen::Matrix3d& homography, const Eigen::Vector2f& ideal);

}  // namespace rastro
