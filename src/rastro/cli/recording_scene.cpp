// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/recording_scene.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/cli/recorded_frames.h"
#include "rastro/cli/scene_input.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/recording.h"
#include "rastro/map/graph/planar.h"
#include "rastro/viewer/frame_block.h"
#include "rastro/viewer/scene_writer.h"

namespace rastro::cli {
namespace {

/// Scans are small: all of them are read, for their stamps and poses.
std::vector<RecordedPose> poses_of_scans(const std::string& path) {
  const auto source = open(path);
  std::vector<RecordedPose> poses;
  for (;;) {
    try {
      const auto frame = source->next();
      if (!frame) return poses;
      poses.resize(std::max(poses.size(), static_cast<std::size_t>(frame->index) + 1));
      RecordedPose& pose = poses[static_cast<std::size_t>(frame->index)];
      pose.stamp = frame->stamp;
      pose.pose = pose_at(source->info().ground_truth, frame->stamp, 200'000'000);
      if (!pose.pose && frame->odometry_from_body) pose.pose = in_space(*frame->odometry_from_body);
    } catch (const UnusableSource&) {
      return poses;
    } catch (const Error&) {  // one frame
    }
  }
}

/// Of a video or a bag: from the first two frames.
std::vector<RecordedPose> evenly_spaced(const std::string& path) {
  OpenOptions options;
  options.read_ahead = 0;
  const auto source = open(path, options);
  std::vector<RecordedPose> poses;
  const auto first = source->next(), second = first ? source->next() : std::nullopt;
  if (!first) return poses;
  const TimeNs step = second ? second->stamp - first->stamp : 0;
  const std::int64_t count = std::max<std::int64_t>(source->info().frame_count, second ? 2 : 1);
  for (std::int64_t k = 0; k < count; ++k) poses.push_back({first->stamp + k * step, std::nullopt});
  return poses;
}

std::vector<RecordedPose> poses_of(const std::string& path, const SourceInfo& info) {
  if (!info.has_image) return poses_of_scans(path);
  std::vector<RecordedPose> poses;
  if (const auto recording = index_recording(path, {})) {
    for (const RecordedFrame& frame : recording->frames) poses.push_back({frame.stamp, std::nullopt});
  } else {
    poses = evenly_spaced(path);
  }
  for (RecordedPose& each : poses) each.pose = true_pose(info, each.stamp);
  return poses;
}

}  // namespace

NamedScene recording_scene(const std::string& path) {
  const auto frames = std::make_shared<FramesOnRequest>(path);
  const std::vector<RecordedPose> poses = poses_of(path, frames->info());
  if (poses.empty()) throw Error("has no frames", path, "'rastro check' lists what is wrong");
  ViewScene scene = scene_of_recorded(poses, frames->info());
  scene.title = scene_name(path);
  NamedScene named{scene.title, scene_bytes(scene)};
  named.frame_block = [frames](std::int64_t frame) { return frame_block(frames->frame(frame), frames->info()); };
  return named;
}

}  // namespace rastro::cli
