// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/recorded_frames.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/cli/scene_input.h"
#include "rastro/dataset/open.h"

namespace rastro::cli {
namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

void add_frames(const std::vector<RecordedPose>& poses, ViewScene& scene) {
  TimeNs last = std::numeric_limits<TimeNs>::min();
  for (const RecordedPose& each : poses) {
    last = std::max(last, each.stamp);  // some loggers' clocks go back: 'rastro check' tells
    scene.frames.stamps_s.push_back(to_seconds(last));
    if (!each.pose) {
      scene.frames.positions.insert(scene.frames.positions.end(), 3, unknown);
      scene.frames.orientations.insert(scene.frames.orientations.end(), 4, unknown);
      continue;
    }
    const Eigen::Vector3f position = each.pose->translation().cast<float>();
    const Eigen::Vector4f orientation = each.pose->rotation().quaternion().coeffs().cast<float>();
    scene.frames.positions.insert(scene.frames.positions.end(), position.begin(), position.end());
    scene.frames.orientations.insert(scene.frames.orientations.end(), orientation.begin(), orientation.end());
  }
}

}  // namespace

FramesOnRequest::FramesOnRequest(std::string path) : path_(std::move(path)) { reopen(0); }

Frame FramesOnRequest::frame(std::int64_t index) {
  constexpr std::int64_t far = 20;
  if (index < next_ || index > next_ + far) reopen(index);
  for (;;) {
    auto frame = source_->next();
    if (!frame) break;
    next_ = frame->index + 1;
    if (frame->index < index) continue;
    if (frame->index > index) break;
    return *std::move(frame);
  }
  throw Error("has no such frame", path_, "");
}

void FramesOnRequest::reopen(std::int64_t first) {
  OpenOptions options;
  options.first_frame = first;
  options.want_color = options.want_depth = true;
  options.read_ahead = 0;
  source_ = open(path_, options);
  next_ = first;
}

std::optional<SE3> true_pose(const SourceInfo& info, TimeNs stamp) {
  constexpr TimeNs max_gap = 200'000'000;
  const auto pose = pose_at(info.ground_truth, stamp, max_gap);
  if (!pose || info.ground_truth_frame != "body" || info.cameras.empty()) return pose;
  return *pose * info.cameras.front().body_from_camera.value_or(SE3());
}

ViewScene scene_of_recorded(const std::vector<RecordedPose>& poses, const SourceInfo& info) {
  ViewScene scene;
  scene.method = info.format;
  scene.metric = true;
  scene.planar = !info.has_image;
  add_frames(poses, scene);
  Trajectory known;
  for (const RecordedPose& each : poses)
    if (each.pose) known.push_back({each.stamp, *each.pose});
  if (!known.empty()) scene.up = up_of(known, scene.planar);
  if (scene.planar) scene.up = {0.0, 0.0, 1.0};
  const bool calibrated = info.has_image && !info.cameras.empty() && info.cameras.front().camera;
  if (calibrated) {
    const Camera& camera = *info.cameras.front().camera;
    scene.camera = SceneCamera{camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy};
  }
  return scene;
}

}  // namespace rastro::cli
