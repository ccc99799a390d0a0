// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/graph/map.h"
#include "rastro/viewer/build_scene.h"
#include "rastro/viewer/scene.h"

namespace rastro::detail {

/// The keyframes of a map that a scene shows, and their rows in it.
class KeyframeRows {
 public:
  KeyframeRows(const Map& map, int submap);
  /// Indices into Map::keyframes, ascending.
  const std::vector<std::size_t>& shown() const { return shown_; }
  /// nullopt for a keyframe that is not shown.
  std::optional<std::uint32_t> row(std::size_t index) const;
  std::optional<std::uint32_t> row_of(const Map& map, KeyframeId id) const;

 private:
  std::vector<std::size_t> shown_;
  std::vector<std::int64_t> rows_;  ///< -1: not shown.
};

/// One build of a scene.
struct SceneJob {
  const Map& map;
  const ViewSceneOptions& options;
  const KeyframeRows& rows;
  TaskPool& pool;
  const MapProgress& progress;
};

// Each adds what the map has of one kind, and nothing where it has none of it.

void add_graphs(const SceneJob& job, ViewScene& scene);
void add_landmarks(const SceneJob& job, ViewScene& scene);
/// Points of all layers but landmarks.
void add_layer_points(const SceneJob& job, ViewScene& scene);
/// Of depth images. Returns the whole cloud; empty without images.
PointCloud add_cloud(const SceneJob& job, ViewScene& scene);
void add_grid(const SceneJob& job, ViewScene& scene);
/// Mesh and octree, where the options ask for them.
void add_surfaces(const SceneJob& job, ViewScene& scene);
void add_images(const SceneJob& job, ViewScene& scene);

inline void append(std::vector<float>& numbers, const Eigen::Vector3d& vector) {
  for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<float>(vector[axis]));
}

/// x y z w.
inline void append(std::vector<float>& numbers, const Eigen::Quaterniond& rotation) {
  for (const double each : {rotation.x(), rotation.y(), rotation.z(), rotation.w()})
    numbers.push_back(static_cast<float>(each));
}

/// Stamps, positions and orientations, and nothing else. In the order of time.
void set_frames(const Trajectory& trajectory, SceneFrames& frames);

/// The three semi-axes of the ellipsoid of one sigma, column by column.
void append_axes(std::vector<float>& numbers, const Eigen::Matrix3d& covariance);

/// `most` indices of [0, count), evenly spread; all where they are not more.
std::vector<std::size_t> evenly(std::size_t count, std::size_t most);

}  // namespace rastro::detail
