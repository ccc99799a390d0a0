// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/frame_trajectory.h"

#include <algorithm>

#include "rastro/optimize/pose_refinement.h"

namespace rastro {
namespace {

SE3 pose_of(const MapGraph& graph, const TrackedFrame& frame) {
  const double scale = graph.unit(frame.keyframe) / frame.unit;
  const SE3 from_keyframe(frame.camera_from_keyframe.rotation(), scale * frame.camera_from_keyframe.translation());
  return from_keyframe * graph.camera_from_world(frame.keyframe);
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

}  // namespace

/// An eighth more: doubling takes twice the memory. Not std::deque, whose small blocks stay scattered between what
/// comes and goes, and keep a page of memory each.
void FrameTrajectory::make_room() {
  constexpr std::size_t least = 256;
  if (frames_.size() == frames_.capacity()) frames_.reserve(frames_.size() + std::max(least, frames_.size() / 8));
}

void FrameTrajectory::add(const TrackedFrame& frame) {
  make_room();
  const auto at = std::upper_bound(frames_.begin(), frames_.end(), frame.index,
                                   [](std::int64_t index, const TrackedFrame& other) { return index < other.index; });
  const auto added = frames_.insert(at, frame);
  if (!keeps_observations_) added->measured.reset();
}

void FrameTrajectory::forget_observations() {
  keeps_observations_ = false;
  for (TrackedFrame& frame : frames_) frame.measured.reset();
}

std::size_t FrameTrajectory::bytes() const {
  std::size_t bytes = frames_.size() * sizeof(TrackedFrame);
  for (const TrackedFrame& frame : frames_) {
    if (!frame.measured) continue;
    bytes += sizeof(FrameMeasurements) + frame.measured->seen.size() * sizeof(FrameObservation) +
             (frame.measured->direct ? sizeof(DirectObservation) : 0);
  }
  return bytes;
}

bool FrameTrajectory::repeat_last(std::int64_t index, TimeNs stamp) {
  if (frames_.empty() || frames_.back().index >= index || frames_.back().stamp >= stamp) return false;
  make_room();
  TrackedFrame frame = frames_.back();
  frame.index = index;
  frame.stamp = stamp;
  frames_.push_back(std::move(frame));
  return true;
}

void FrameTrajectory::set_keyframe(std::int64_t index, std::int64_t keyframe) {
  for (auto frame = frames_.rbegin(); frame != frames_.rend(); ++frame) {
    if (frame->index == index) frame->became = keyframe;
    if (frame->index <= index) return;
  }
}

void FrameTrajectory::forget(const MapGraph& graph, int submap) {
  std::erase_if(frames_, [&](const TrackedFrame& frame) { return graph.submap(frame.keyframe) == submap; });
}

std::vector<TrackedFrame> FrameTrajectory::take_observed(std::size_t kept, std::size_t least) {
  const auto observed = static_cast<std::size_t>(std::count_if(
      frames_.begin(), frames_.end(), [](const TrackedFrame& frame) { return frame.measured != nullptr; }));
  std::vector<TrackedFrame> taken;
  if (observed < kept + least) return taken;
  for (TrackedFrame& frame : frames_) {
    if (taken.size() == observed - kept) break;
    if (!frame.measured) continue;
    taken.push_back(frame);
    frame.measured.reset();
  }
  return taken;
}

void FrameTrajectory::put_back(const std::vector<TrackedFrame>& refined) {
  for (const TrackedFrame& frame : refined) {
    const auto here =
        std::lower_bound(frames_.begin(), frames_.end(), frame.index,
                         [](const TrackedFrame& other, std::int64_t index) { return other.index < index; });
    if (here == frames_.end() || here->index != frame.index) continue;
    here->keyframe = frame.keyframe;
    here->camera_from_keyframe = frame.camera_from_keyframe;
    here->unit = frame.unit;
  }
}

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
  const PoseRefinement refined = refine_pose(pose_of(graph, frame), observations, {.baseline = graph.baseline()});
  if (refined.inliers < least) return;
  frame.camera_from_keyframe = with_direct(frame, graph, refined) * graph.camera_from_world(frame.keyframe).inverse();
  frame.unit = graph.unit(frame.keyframe);
}

void FrameTrajectory::refine(const MapGraph& graph, int least) {
  for (TrackedFrame& frame : frames_) refine_frame(frame, graph, least);
}

Trajectory FrameTrajectory::trajectory(const MapGraph& graph, int submap) const {
  Trajectory poses;
  for (const TrackedFrame& frame : frames_) {
    if (graph.submap(frame.keyframe) != submap) continue;
    poses.push_back({frame.stamp, pose_of(graph, frame).inverse()});
  }
  return poses;
}

int FrameTrajectory::largest_submap(const MapGraph& graph) const {
  std::vector<int> counts(static_cast<std::size_t>(std::max(1, graph.submap_count())), 0);
  for (const TrackedFrame& frame : frames_) ++counts[static_cast<std::size_t>(graph.submap(frame.keyframe))];
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

}  // namespace rastro
