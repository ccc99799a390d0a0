// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/recording_scene.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/cli/scene_input.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/recording.h"
#include "rastro/map/graph/planar.h"
#include "rastro/viewer/frame_block.h"
#include "rastro/viewer/scene_writer.h"

namespace rastro::cli {
namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

/// A frame's place on the timeline.
struct RecordedPose {
  TimeNs stamp = 0;
  std::optional<SE3> pose;  ///< world_from_camera, or of the body of a laser.
};

/// Reads any frame: the next ones by going on, others by opening the recording there.
class FrameReaderOnRequest {
 public:
  explicit FrameReaderOnRequest(std::string path) : path_(std::move(path)) { reopen(0); }

  const SourceInfo& info() const { return source_->info(); }

  std::string block(std::int64_t index) {
    constexpr std::int64_t far = 20;
    if (index < next_ || index > next_ + far) reopen(index);
    for (;;) {
      auto frame = source_->next();
      if (!frame) break;
      next_ = frame->index + 1;
      if (frame->index < index) continue;
      if (frame->index > index) break;
      return frame_block(*frame, info());
    }
    throw Error("has no such frame", path_, "");
  }

 private:
  void reopen(std::int64_t first) {
    OpenOptions options;
    options.first_frame = first;
    options.want_color = options.want_depth = true;
    options.read_ahead = 0;
    source_ = open(path_, options);
    next_ = first;
  }

  std::string path_;
  std::unique_ptr<Source> source_;
  std::int64_t next_ = 0;
};

/// world_from_camera by the ground truth of the recording; nullopt where it has none at that time.
std::optional<SE3> true_pose(const SourceInfo& info, TimeNs stamp) {
  constexpr TimeNs max_gap = 200'000'000;
  const auto pose = pose_at(info.ground_truth, stamp, max_gap);
  if (!pose || info.ground_truth_frame != "body" || info.cameras.empty()) return pose;
  return *pose * info.cameras.front().body_from_camera.value_or(SE3());
}

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

ViewScene scene_of_frames(const std::string& path, const SourceInfo& info) {
  const std::vector<RecordedPose> poses = poses_of(path, info);
  if (poses.empty()) throw Error("has no frames", path, "'rastro check' lists what is wrong");
  ViewScene scene;
  scene.title = scene_name(path);
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

}  // namespace

NamedScene recording_scene(const std::string& path) {
  const auto reader = std::make_shared<FrameReaderOnRequest>(path);
  const ViewScene scene = scene_of_frames(path, reader->info());
  NamedScene named{scene.title, scene_bytes(scene)};
  named.frame_block = [reader](std::int64_t frame) { return reader->block(frame); };
  return named;
}

}  // namespace rastro::cli
