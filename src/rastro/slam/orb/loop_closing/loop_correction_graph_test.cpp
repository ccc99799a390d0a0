// SPDX-License-Identifier: Apache-2.0
// Against the pose graph of a loop, made by its definition.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "rastro/math/math_testing.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/slam/orb/loop_closing/loop_correction.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::PointWorld;
using testing::pose_near;

constexpr std::int64_t newest_id = 7, revisited_id = 1;

SE3 along_row(std::int64_t k) {
  const auto t = static_cast<double>(k);
  return {SO3::exp({0.01 * t, -0.02 * t, 0.03 * t}), {-0.15 * t, 0.05 * t, 0.02 * t}};
}

/// Eight keyframes in a row that share landmarks with the next three, an earlier loop, and a submap of its own.
struct RowToCorrect {
  explicit RowToCorrect(CameraKind sensor) : map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1) {
    for (std::int64_t k = 0; k <= newest_id; ++k) {
      const auto first = static_cast<std::uint32_t>(30 * k);
      map.add(k, along_row(k), {.from = first, .to = first + 100});
    }
    graph.constraints().push_back({.from = 4, .to = 1, .from_from_to = {}, .kind = ConstraintKind::loop, .inliers = 9});
    for (const std::int64_t k : {8, 9}) apart.add(k, along_row(k), {}, 1);
    graph.constraints().push_back({.from = 9, .to = 8, .from_from_to = {}, .kind = ConstraintKind::loop, .inliers = 9});
  }
  PointWorld world{340, 5}, elsewhere{60, 8};
  ExactMap map;
  MapGraph& graph = map.graph;
  ExactMap apart{elsewhere, graph};
};

/// The poses of the definition: tree, earlier loops and strong covisibility keep the relative poses from before, while
/// those around the last keyframe begin where the loop says.
std::vector<Sim3> corrected(const MapGraph& graph, const OrbSlamOptions& options, const VerifiedLoop& loop) {
  std::vector<Sim3> before, poses;
  for (std::int64_t k = 0; k <= newest_id; ++k) before.emplace_back(graph.camera_from_world(k).inverse());
  poses = before;
  const auto at = [](std::int64_t id) { return static_cast<std::size_t>(id); };
  const Sim3 predicted = (loop.keyframe_from_matched * Sim3(graph.camera_from_world(revisited_id))).inverse();
  for (std::int64_t k = 0; k <= newest_id; ++k) {
    if (k == newest_id || graph.shared(k, newest_id) >= options.covisible_landmarks)
      poses[at(k)] = predicted * before[at(newest_id)].inverse() * before[at(k)];
  }
  std::vector<Constraint> edges;
  const auto add = [&](std::int64_t from, std::int64_t to, const Sim3& relative) {
    edges.push_back({.from = from, .to = to, .from_from_to = relative});
  };
  for (std::int64_t from = 0; from <= newest_id; ++from) {
    for (std::int64_t to = 0; to < from; ++to) {
      const bool holds = to == from - 1 || graph.shared(from, to) >= options.essential_landmarks;
      if (holds) add(from, to, before[at(from)].inverse() * before[at(to)]);
    }
  }
  add(4, 1, before[4].inverse() * before[1]);
  add(newest_id, revisited_id, loop.keyframe_from_matched);
  PoseGraphOptions settings;
  settings.loops = LoopModel::trusted;
  settings.fix_scale = graph.sensor() != CameraKind::mono;
  std::vector<std::uint8_t> fixed(poses.size(), 0);
  fixed[0] = 1;
  optimize_pose_graph(poses, std::span(edges), std::span<const std::uint8_t>(fixed), settings);
  return poses;
}

TEST(LoopCorrectionGraph, KeyframesGoWhereTreeLoopsAndStrongCovisibilityLetThem) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    for (const int beyond : {0, 1}) {
      RowToCorrect row(sensor);
      OrbSlamOptions options;
      options.covisible_landmarks = 15;
      options.essential_landmarks = row.graph.shared(2, 4) + beyond;
      options.loop_search_px = 0.001;  // nothing is fused
      VerifiedLoop loop;
      loop.keyframe = newest_id;
      loop.matched = revisited_id;
      const SE3 relative = along_row(newest_id) * along_row(revisited_id).inverse();
      const double scale = sensor == CameraKind::mono ? 1.15 : 1.0;
      loop.keyframe_from_matched = Sim3(scale, SO3::exp({0.01, 0.03, -0.02}) * relative.rotation(),
                                        scale * relative.translation() + Eigen::Vector3d(0.05, 0.1, -0.08));
      std::map<std::int64_t, Eigen::Vector3d> apart;
      for (const std::int64_t id : row.apart.landmark_of)
        if (id >= 0) apart[id] = row.graph.landmark(id).position;
      const std::vector<Sim3> expected = corrected(row.graph, options, loop);
      const LoopResult result = correct_loop(row.graph, options, loop);
      EXPECT_EQ(result.fused, 0);
      double moved_most = 0.0;
      for (std::int64_t k = 0; k <= newest_id; ++k) {
        const Sim3& pose = expected[static_cast<std::size_t>(k)];
        EXPECT_THAT(row.graph.camera_from_world(k).inverse(),
                    pose_near(SE3(pose.rotation(), pose.translation()), 1e-7, 1e-7))
            << k;
        EXPECT_NEAR(row.graph.unit(k), pose.scale(), 1e-7) << k;
        moved_most = std::max(moved_most, (pose.translation() - along_row(k).inverse().translation()).norm());
      }
      EXPECT_GT(moved_most, 0.03);
      for (const std::int64_t k : {8, 9}) EXPECT_EQ(row.graph.camera_from_world(k).matrix(), along_row(k).matrix());
      for (const auto& [id, position] : apart) EXPECT_EQ(row.graph.landmark(id).position, position);
    }
  }
}

}  // namespace
}  // namespace rastro
