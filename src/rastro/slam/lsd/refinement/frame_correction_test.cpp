// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/refinement/frame_correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace rastro {
namespace {

constexpr double unit = 2.0;  // of both keyframes, in the world's

/// world_from_camera of a turning walk.
SE3 truth(std::int64_t frame) {
  const double t = static_cast<double>(frame);
  return {SO3::exp({0.001 * t, 0.01 * t, 0.0}), {0.05 * t, 0.0, 0.002 * t * t}};
}

SE3 in_units(const SE3& metric) { return {metric.rotation(), metric.translation() / unit}; }

/// Keyframes at frames 0 and 10 where they truly are; frames 0 to 12 were aligned with the first one, whose depths were
/// too large by a tenth, and 13 to 19 with the second one, without error.
SemiDenseGraph corrected_walk() {
  SemiDenseGraph graph(LsdOptions{}, false);
  for (const std::int64_t frame : {0, 10}) {
    const SemiDenseKeyframe keyframe{graph.size(), frame, frame, GrayImage(), InverseDepthMap()};
    graph.add(std::make_shared<const SemiDenseKeyframe>(keyframe),
              Sim3(unit, truth(frame).rotation(), truth(frame).translation()), 0);
  }
  for (std::int64_t frame = 0; frame < 20; ++frame) {
    const std::int64_t keyframe = frame <= 12 ? 0 : 1, origin = keyframe == 0 ? 0 : 10;
    SE3 placed = in_units(truth(origin).inverse() * truth(frame));
    if (keyframe == 0) placed = SE3(placed.rotation(), 1.1 * placed.translation());
    graph.add_frame({frame, frame, keyframe, placed});
  }
  return graph;
}

double position_error(const SemiDenseGraph& graph, std::size_t frame) {
  const PlacedFrame& placed = graph.frames()[frame];
  return (graph.pose_of(placed).translation() - truth(placed.index).translation()).norm();
}

TEST(FrameCorrection, FramesMoveWithTheKeyframeThatTheirWalkBecame) {
  SemiDenseGraph graph = corrected_walk();
  const SemiDenseGraph before = graph;
  graph.set_frames(frames_between_corrected_keyframes(graph));
  EXPECT_GT(position_error(before, 10), 0.05);
  EXPECT_LT(position_error(graph, 10), 1e-9) << "it is the keyframe";
  for (std::size_t frame = 1; frame <= 12; ++frame)
    EXPECT_LT(position_error(graph, frame), 0.4 * position_error(before, frame)) << frame;
  for (std::size_t frame = 13; frame < 20; ++frame)
    EXPECT_EQ(position_error(graph, frame), position_error(before, frame)) << frame << ", after the last keyframe";
}

TEST(FrameCorrection, WhatFitsStaysAsItIs) {
  SemiDenseGraph graph = corrected_walk();
  graph.set_frames(frames_between_corrected_keyframes(graph));
  const std::vector<PlacedFrame> again = frames_between_corrected_keyframes(graph);
  for (std::size_t frame = 0; frame <= 10; ++frame) {
    const SE3 change = graph.frames()[frame].keyframe_from_camera.inverse() * again[frame].keyframe_from_camera;
    EXPECT_LT(change.log().norm(), 1e-12) << frame;
  }
}

TEST(FrameCorrection, AKeyframeOfAnotherSubmapSaysNothing) {
  SemiDenseGraph graph(LsdOptions{}, false);
  for (const int submap : {0, 1}) {
    const SemiDenseKeyframe keyframe{submap, 10 * submap, 10 * submap, GrayImage(), InverseDepthMap()};
    graph.add(std::make_shared<const SemiDenseKeyframe>(keyframe), Sim3(1.0, SO3(), {5.0 * submap, 0.0, 0.0}), submap);
  }
  for (std::int64_t frame = 0; frame <= 10; ++frame)
    graph.add_frame({frame, frame, 0, SE3(SO3(), {0.1 * static_cast<double>(frame), 0.0, 0.0})});
  const std::vector<PlacedFrame> corrected = frames_between_corrected_keyframes(graph);
  EXPECT_EQ(corrected.back().keyframe_from_camera.translation(),
            graph.frames().back().keyframe_from_camera.translation());
}

}  // namespace
}  // namespace rastro
