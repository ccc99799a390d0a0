// SPDX-License-Identifier: Apache-2.0
// Poses as text that is equal for repeated runs, and checks that hold for all.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "rastro/sensor/trajectory.h"

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

inline void expect_sound(const SE3& pose) {
  const Eigen::Matrix3d rotation = pose.rotation().matrix();
  EXPECT_TRUE(pose.translation().allFinite());
  EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace rastro
