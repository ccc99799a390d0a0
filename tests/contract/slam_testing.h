// SPDX-License-Identifier: Apache-2.0
// Results of a SLAM method as text that is equal for repeated runs, and checks that hold for every method.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <string>

#include "pose_testing.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/layer_type.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// Everything of an update except times.
inline std::string text_of(const SlamUpdate& update) {
  std::string text = fmt::format("{} {} {} {} {} {} {} ", update.index, update.stamp, name_of(update.state),
                                 name_of(update.reason), update.detail, update.score, update.used);
  for (const SlamEvent& event : update.events) text += event.kind + ":" + event.detail + " ";
  if (update.covariance)
    for (const double entry : update.covariance->reshaped()) text += fmt::format("{} ", entry);
  return text + text_of(update.world_from_body);
}

/// Headers and rows of all layers, as a file would have them.
inline std::string text_of_layers(const Map& map) {
  std::string text;
  for (const auto& [name, layer] : map.layers.all()) {
    const LayerType* type = layer_type(name);
    text += "\n" + name + "\n";
    if (!type) continue;
    text += type->header(*layer);
    for (const std::int64_t id : type->rows(*layer)) text += fmt::format("\n{} ", id) + type->row(*layer, id);
  }
  return text;
}

/// Keyframes, constraints and layers of a map: all except frames and counts.
inline std::string text_of_kept(const Map& map) {
  std::string text;
  for (const Keyframe& keyframe : map.keyframes)
    text +=
        fmt::format("{} {} {} ", keyframe.id, keyframe.submap, keyframe.parent) + text_of(keyframe.world_from_camera);
  for (const Constraint& constraint : map.constraints)
    text += fmt::format("{} {} {} ", constraint.from, constraint.to, constraint.weight) + text_of(constraint.rigid());
  return text + text_of_layers(map);
}

inline std::string text_of(const Map& map) {
  std::string text = fmt::format("{} {}\n", map.method, map.revision);
  for (const MapCamera& camera : map.cameras)
    text += fmt::format("{} {} {} ", name_of(camera.kind), camera.intrinsics.fx, camera.baseline) +
            text_of(camera.body_from_camera);
  for (const MapSession& session : map.sessions)
    text +=
        fmt::format("{} {} {} {} {} {} {} {}\n", session.robot, session.session, session.recording, session.first_stamp,
                    session.last_stamp, session.scale.metric, session.scale.relative_sigma, session.scale.origin);
  for (const Keyframe& keyframe : map.keyframes)
    text += fmt::format("{} {} {} {} {} {} {} ", keyframe.id, keyframe.frame, keyframe.stamp, keyframe.camera,
                        keyframe.submap, keyframe.parent, keyframe.weight) +
            text_of(keyframe.world_from_camera);
  for (const Constraint& constraint : map.constraints)
    text += fmt::format("{} {} {} {} {} {} {} ", constraint.from, constraint.to, name_of(constraint.kind),
                        constraint.weight, constraint.inliers, constraint.information.sum(),
                        constraint.from_from_to.scale()) +
            text_of(constraint.rigid());
  for (const MapFrame& frame : map.frames)
    text += fmt::format("{} {} ", frame.stamp, frame.keyframe) + text_of(frame.keyframe_from_camera);
  return text + text_of_layers(map);
}

inline void expect_sound(const Eigen::MatrixXd& covariance) {
  ASSERT_TRUE(covariance.allFinite());
  const double size = covariance.cwiseAbs().maxCoeff();
  EXPECT_LE((covariance - covariance.transpose()).cwiseAbs().maxCoeff(), 1e-12 * size);
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvalues().minCoeff(), -1e-9 * size);
}

inline void expect_sound(const SlamUpdate& update, const Frame& frame) {
  SCOPED_TRACE(fmt::format("frame {} ({}, {})", frame.index, name_of(update.state), name_of(update.reason)));
  EXPECT_EQ(update.index, frame.index);
  EXPECT_EQ(update.stamp, frame.stamp);
  expect_sound(update.world_from_body);
  if (update.covariance) expect_sound(Eigen::MatrixXd(*update.covariance));
  EXPECT_GE(update.score, 0.0);
  EXPECT_LE(update.score, 1.0);
  EXPECT_GE(update.used, 0);
  EXPECT_GE(update.milliseconds, 0.0);
  for (const SlamEvent& event : update.events) EXPECT_FALSE(event.kind.empty());
  for (const StageTime& time : update.times) EXPECT_GE(time.milliseconds, 0.0) << time.stage;
}

inline void expect_sound(const Trajectory& trajectory) {
  for (std::size_t k = 0; k < trajectory.size(); ++k) {
    expect_sound(trajectory[k].world_from_body);
    if (k > 0) {
      EXPECT_GT(trajectory[k].stamp, trajectory[k - 1].stamp);
    }
  }
}

inline void expect_sound(const Constraint& constraint) {
  SCOPED_TRACE(fmt::format("{} from {} to {}", name_of(constraint.kind), constraint.from, constraint.to));
  expect_sound(constraint.rigid());
  EXPECT_GT(constraint.from_from_to.scale(), 0.0);
  EXPECT_NE(constraint.from, constraint.to);
  EXPECT_TRUE(constraint.information.allFinite());
  EXPECT_GE(constraint.weight, 0.0);
  EXPECT_LE(constraint.weight, 1.0);
  EXPECT_GE(constraint.inliers, 0);
}

inline void expect_sound(const OccupancyGrid& grid) {
  grid.percent.for_each([&](int x, int y, std::int8_t percent) {
    ASSERT_TRUE(percent >= OccupancyGrid::unknown && percent <= 100);
    ASSERT_TRUE(percent == OccupancyGrid::unknown || grid.holds(x, y));
  });
}

inline void expect_sound(const Map& map) {
  EXPECT_EQ(contradiction_in(map), "");
  EXPECT_FALSE(map.method.empty());
  // In the order of their ids, in which they were made: with decreasing stamps this is not the order of time.
  for (const Keyframe& keyframe : map.keyframes) expect_sound(keyframe.world_from_camera);
  for (const Constraint& constraint : map.constraints) expect_sound(constraint);
  for (const MapFrame& frame : map.frames) expect_sound(frame.keyframe_from_camera);
  if (const auto known = map.layer<LandmarkLayer>()) {
    for (const LandmarkEstimate& estimate : known->estimates) {
      expect_sound(Eigen::MatrixXd(estimate.covariance));
      EXPECT_GT(estimate.observations, 0);
    }
  }
  if (const auto grid = occupancy_grid_of(map)) expect_sound(*grid);
}

}  // namespace rastro
