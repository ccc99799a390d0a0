// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/frame_trajectory.h"

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/optimize/pose_refinement.h"

namespace rastro {
namespace {

/// camera_from_world
SE3 pose_of(const MapGraph& graph, std::int64_t keyframe, double unit, const SE3& camera_from_keyframe) {
  const double scale = graph.unit(keyframe) / unit;
  const SE3 from_keyframe(camera_from_keyframe.rotation(), scale * camera_from_keyframe.translation());
  return from_keyframe * graph.camera_from_world(keyframe);
}

/// Features and images together, where there are both.
SE3 with_direct(const TrackedFrame& frame, const MapGraph& graph, const PoseRefinement& refined) {
  const DirectObservation* observed = frame.measured->direct.get();
  if (observed == nullptr || graph.submap(observed->keyframe) != graph.submap(frame.keyframe))
    return refined.camera_from_world;
  const RelativePose& direct = observed->pose;
  const SE3 by_images = direct.camera_from_keyframe * graph.camera_from_world(observed->keyframe);
  return fused({refined.camera_from_world, refined.covariance}, {by_images, direct.covariance}).camera_from_keyframe;
}

/// Of a list by index: the first entry that is not before `index`.
template <typename List>
auto entry_at(List& list, std::int64_t index) {
  return std::lower_bound(list.begin(), list.end(), index,
                          [](const auto& entry, std::int64_t wanted) { return entry.first < wanted; });
}

template <typename T>
T value_of(const std::vector<std::pair<std::int64_t, T>>& list, std::int64_t index, const T& none) {
  const auto at = entry_at(list, index);
  return at != list.end() && at->first == index ? at->second : none;
}

template <typename T>
void set_value(std::vector<std::pair<std::int64_t, T>>& list, std::int64_t index, const T& value, const T& none) {
  const auto at = entry_at(list, index);
  const bool is_there = at != list.end() && at->first == index;
  if (value == none) {
    if (is_there) list.erase(at);
  } else if (is_there) {
    at->second = value;
  } else {
    list.insert(at, {index, value});
  }
}

}  // namespace

void refine_frame(TrackedFrame& frame, const MapGraph& graph, int least) {
  if (frame.became >= 0 && graph.has_keyframe(frame.became)) {
    frame = {frame.index, frame.stamp, frame.became, graph.unit(frame.became), SE3(), frame.became, {}};
    return;
  }
  if (!frame.measured) return;
  const int submap = graph.submap(frame.keyframe);
  std::vector<PoseObservation> observations;
  for (const FrameObservation& seen : frame.measured->seen) {
    const std::int64_t id = graph.current(seen.landmark);
    if (id < 0 || graph.landmark(id).observations.empty()) continue;
    const MapLandmark& landmark = graph.landmark(id);
    if (graph.submap(landmark.observations.front().keyframe) != submap) continue;
    observations.push_back(
        {landmark.position, seen.ray.cast<double>(), static_cast<double>(seen.right), static_cast<double>(seen.sigma)});
  }
  const SE3 before = pose_of(graph, frame.keyframe, frame.unit, frame.camera_from_keyframe);
  const PoseRefinement refined = refine_pose(before, observations, {.baseline = graph.baseline()});
  if (refined.inliers < least) return;
  frame.camera_from_keyframe = with_direct(frame, graph, refined) * graph.camera_from_world(frame.keyframe).inverse();
  frame.unit = graph.unit(frame.keyframe);
}

FrameTrajectory::Pose FrameTrajectory::packed(const TrackedFrame& frame) {
  const auto index = static_cast<std::uint32_t>(frame.index);
  const auto keyframe = static_cast<std::int32_t>(frame.keyframe);
  RASTRO_CHECK(index == frame.index && keyframe == frame.keyframe, "frames and keyframes are counted from 0");
  return {frame.stamp, frame.unit, PackedSE3(frame.camera_from_keyframe), index, keyframe};
}

TrackedFrame FrameTrajectory::frame(std::size_t k) const {
  const Pose& pose = poses_[k];
  return {pose.index,
          pose.stamp,
          pose.keyframe,
          pose.unit,
          pose.camera_from_keyframe.pose(),
          value_of(became_, pose.index, std::int64_t{-1}),
          value_of(measured_, pose.index, std::shared_ptr<const FrameMeasurements>())};
}

void FrameTrajectory::set(std::size_t k, const TrackedFrame& frame) {
  poses_[k] = packed(frame);
  set_value(became_, frame.index, frame.became, std::int64_t{-1});
  set_value(measured_, frame.index, frame.measured, std::shared_ptr<const FrameMeasurements>());
}

std::size_t FrameTrajectory::position_of(std::int64_t index) const {
  const auto at = std::lower_bound(poses_.begin(), poses_.end(), index,
                                   [](const Pose& pose, std::int64_t wanted) { return pose.index < wanted; });
  return at != poses_.end() && at->index == index ? static_cast<std::size_t>(at - poses_.begin()) : poses_.size();
}

/// An eighth more: doubling takes twice the memory. Not std::deque, whose small blocks stay scattered between what
/// comes and goes, and keep a page of memory each.
void FrameTrajectory::make_room() {
  constexpr std::size_t least = 256;
  if (poses_.size() == poses_.capacity()) poses_.reserve(poses_.size() + std::max(least, poses_.size() / 8));
}

void FrameTrajectory::add(const TrackedFrame& frame) {
  make_room();
  const auto at = std::upper_bound(poses_.begin(), poses_.end(), frame.index,
                                   [](std::int64_t index, const Pose& pose) { return index < pose.index; });
  const auto k = static_cast<std::size_t>(poses_.insert(at, packed(frame)) - poses_.begin());
  set(k, frame);
  if (!keeps_observations_) forget_observations();
}

void FrameTrajectory::forget_observations() {
  keeps_observations_ = false;
  measured_ = {};
}

std::size_t FrameTrajectory::bytes() const {
  std::size_t bytes = poses_.size() * sizeof(Pose) + became_.size() * sizeof(became_[0]);
  for (const auto& [index, measured] : measured_) {
    bytes += sizeof(measured_[0]) + sizeof(FrameMeasurements) + measured->seen.size() * sizeof(FrameObservation) +
             (measured->direct ? sizeof(DirectObservation) : 0);
  }
  return bytes;
}

bool FrameTrajectory::repeat_last(std::int64_t index, TimeNs stamp) {
  if (poses_.empty() || poses_.back().index >= index || poses_.back().stamp >= stamp) return false;
  TrackedFrame again = frame(poses_.size() - 1);
  again.index = index;
  again.stamp = stamp;
  add(again);
  return true;
}

void FrameTrajectory::set_keyframe(std::int64_t index, std::int64_t keyframe) {
  if (position_of(index) < poses_.size()) set_value(became_, index, keyframe, std::int64_t{-1});
}

void FrameTrajectory::forget(const MapGraph& graph, int submap) {
  const auto is_in_it = [&](const Pose& pose) { return graph.submap(pose.keyframe) == submap; };
  const auto is_of_it = [&](const auto& entry) { return is_in_it(poses_[position_of(entry.first)]); };
  std::erase_if(measured_, is_of_it);
  std::erase_if(became_, is_of_it);
  std::erase_if(poses_, is_in_it);
}

std::vector<TrackedFrame> FrameTrajectory::take_observed(std::size_t kept, std::size_t least) {
  std::vector<TrackedFrame> taken;
  if (measured_.size() < kept + least) return taken;
  const auto end = measured_.end() - static_cast<std::ptrdiff_t>(kept);
  for (auto at = measured_.begin(); at != end; ++at) taken.push_back(frame(position_of(at->first)));
  measured_.erase(measured_.begin(), end);
  return taken;
}

void FrameTrajectory::put_back(const std::vector<TrackedFrame>& refined) {
  for (const TrackedFrame& frame : refined) {
    const std::size_t k = position_of(frame.index);
    if (k == poses_.size()) continue;
    const TimeNs stamp = poses_[k].stamp;
    poses_[k] = packed(frame);
    poses_[k].stamp = stamp;
  }
}

void FrameTrajectory::refine(const MapGraph& graph, int least) {
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    TrackedFrame refined = frame(k);
    refine_frame(refined, graph, least);
    set(k, refined);
  }
}

Trajectory FrameTrajectory::trajectory(const MapGraph& graph, int submap) const {
  Trajectory poses;
  for (const Pose& pose : poses_) {
    if (graph.submap(pose.keyframe) != submap) continue;
    const SE3 camera_from_world = pose_of(graph, pose.keyframe, pose.unit, pose.camera_from_keyframe.pose());
    poses.push_back({pose.stamp, camera_from_world.inverse()});
  }
  return poses;
}

int FrameTrajectory::largest_submap(const MapGraph& graph) const {
  std::vector<int> counts(static_cast<std::size_t>(std::max(1, graph.submap_count())), 0);
  for (const Pose& pose : poses_) ++counts[static_cast<std::size_t>(graph.submap(pose.keyframe))];
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

}  // namespace rastro
