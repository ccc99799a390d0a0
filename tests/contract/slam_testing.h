// SPDX-License-Identifier: Apache-2.0
// What a SLAM method gives, as text that two runs must share, and what must be true of it whatever the method.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <string>

#include "rastro/slam/slam_method.h"

namespace rastro {

inline std::string text_of(const SE3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation().quaternion();
  return fmt::format("{} {} {} {} {} {} {}\n", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

inline std::string text_of(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& pose : trajectory) text += fmt::format("{} ", pose.stamp) + text_of(pose.world_from_body);
  return text;
}

/// Everything of an update but its times.
inline std::string text_of(const SlamUpdate& update) {
  std::string text = fmt::format("{} {} {} {} {} {} {} ", update.index, update.stamp, name_of(update.state),
                                 name_of(update.reason), update.detail, update.score, update.used);
  for (const SlamEvent& event : update.events) text += event.kind + ":" + event.detail + " ";
  if (update.covariance)
    for (const double entry : update.covariance->reshaped()) text += fmt::format("{} ", entry);
  return text + text_of(update.world_from_body);
}

inline std::string text_of(const LandmarkMap& map) {
  std::string text = fmt::format("{} {} {} ", static_cast<int>(map.sensor), map.baseline, map.scale.origin);
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const LandmarkKeyframe& keyframe = *map.keyframes[k];
    text += fmt::format("{} {} {} {} {} {} ", keyframe.id, keyframe.frame, keyframe.stamp, keyframe.features.size(),
                        map.poses[k].submap, map.poses[k].parent);
    text += text_of(map.poses[k].world_from_camera);
    for (const Keypoint& point : keyframe.features.keypoints) text += fmt::format("{} {} ", point.x, point.y);
  }
  for (const Landmark& landmark : map.landmarks) {
    text += fmt::format("{} {} {} {} {} {}", landmark.id, landmark.position.x(), landmark.position.y(),
                        landmark.position.z(), landmark.min_distance, landmark.max_distance);
    for (const LandmarkObservation& seen : landmark.observations)
      text += fmt::format(" {}:{}", seen.keyframe, seen.feature);
    text += "\n";
  }
  return text + text_of(map.trajectory);
}

inline std::string text_of(const Snapshot& map) {
  std::string text = fmt::format("{}\n", map.revision);
  if (map.grid) {
    text += fmt::format("{} {} {} {} {} ", map.grid->cell_m, map.grid->origin.x(), map.grid->origin.y(),
                        map.grid->width, map.grid->height);
    text.append(map.grid->percent.begin(), map.grid->percent.end());
  }
  for (const PlanarLandmark& landmark : map.landmarks) {
    text += fmt::format("{} {} {} {} {} {} {} {}\n", landmark.id, landmark.sensor_id, landmark.position.x(),
                        landmark.position.y(), landmark.covariance(0, 0), landmark.covariance(0, 1),
                        landmark.covariance(1, 1), landmark.observations);
  }
  if (map.rgbd) {
    for (const PoseEdge& edge : map.rgbd->edges)
      text += fmt::format("{} {} {} ", static_cast<int>(edge.kind), edge.weight, edge.information.sum()) +
              text_of(edge.from_from_to);
    for (const auto& keyframe : map.rgbd->keyframes)
      text += fmt::format("{} {} {}\n", keyframe->id, keyframe->frame, keyframe->features.size());
    text += text_of(map.rgbd->trajectory);
  }
  if (map.landmark_map) text += text_of(*map.landmark_map);
  for (const GraphEdge& edge : map.edges) text += fmt::format("{} {} {}\n", edge.from, edge.to, edge.loop);
  return text + text_of(map.keyframes);
}

inline void expect_sound(const SE3& pose) {
  const Eigen::Matrix3d rotation = pose.rotation().matrix();
  EXPECT_TRUE(pose.translation().allFinite());
  EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-9);
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

inline void expect_sound(const LandmarkMap& map) {
  ASSERT_EQ(map.poses.size(), map.keyframes.size());
  std::map<std::int64_t, std::size_t> features;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    expect_sound(map.poses[k].world_from_camera);
    if (k > 0) {
      EXPECT_GT(map.keyframes[k]->id, map.keyframes[k - 1]->id);
    }
    features[map.keyframes[k]->id] = map.keyframes[k]->features.size();
  }
  for (const Landmark& landmark : map.landmarks) {
    EXPECT_TRUE(landmark.position.allFinite());
    for (const LandmarkObservation& seen : landmark.observations) {
      ASSERT_TRUE(features.contains(seen.keyframe)) << "landmark " << landmark.id << " keyframe " << seen.keyframe;
      EXPECT_LT(seen.feature, features[seen.keyframe]);
    }
  }
}

inline void expect_sound(const Snapshot& map) {
  if (map.landmark_map) expect_sound(*map.landmark_map);
  // In the order in which they were made, which edges count by: where stamps go back it is not that of time.
  for (const StampedPose& keyframe : map.keyframes) expect_sound(keyframe.world_from_body);
  for (const PlanarLandmark& landmark : map.landmarks) {
    EXPECT_TRUE(landmark.position.allFinite());
    expect_sound(Eigen::MatrixXd(landmark.covariance));
    EXPECT_GT(landmark.observations, 0);
  }
  for (const GraphEdge& edge : map.edges) EXPECT_LT(std::max(edge.from, edge.to), map.keyframes.size());
  if (!map.grid) return;
  const auto cells = static_cast<std::size_t>(map.grid->width) * static_cast<std::size_t>(map.grid->height);
  ASSERT_EQ(map.grid->percent.size(), cells);
  for (const std::int8_t percent : map.grid->percent) ASSERT_TRUE(percent >= OccupancyGrid::unknown && percent <= 100);
}

}  // namespace rastro
