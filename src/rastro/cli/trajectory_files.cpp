// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/trajectory_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/cli/common_flags.h"
#include "rastro/dataset/open.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

/// T_BS and where it is from.
struct CameraMount {
  SE3 body_from_camera;
  std::string from;
};

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::optional<CameraMount> mount_of_file(const std::string& file) {
  const Calibration calibration = read_calibration(file);
  const auto& mount = calibration.cameras.front().body_from_camera;
  if (!mount) return std::nullopt;
  return CameraMount{*mount, file};
}

CameraMount given_mount(const std::string& file) {
  const auto mount = mount_of_file(file);
  if (!mount) throw Error("has no pose of the camera on the body", file, "give a sensor.yaml with T_BS");
  return *mount;
}

std::optional<CameraMount> mount_beside(const std::string& ground_truth_file_name) {
  const fs::path file = fs::path(ground_truth_file_name).parent_path() / ".." / "cam0" / "sensor.yaml";
  if (!is_file(file)) return std::nullopt;
  return mount_of_file(file.lexically_normal().string());
}

/// A reference and what is found with it.
struct Found {
  TrajectoryInput input;
  bool of_body = false;
  bool compare_in_body = false;
  std::optional<CameraMount> mount;
  std::optional<StampSpan> recording;
};

/// Of the EuRoC or TUM recording that a ground-truth file lies in.
std::optional<StampSpan> span_beside(const fs::path& ground_truth_file_name) {
  const fs::path folder = ground_truth_file_name.parent_path();
  try {
    if (is_file(folder / ".." / "cam0" / "data.csv")) return span_of_recording((folder / "..").string(), {});
    if (ground_truth_file_name.filename() == "groundtruth.txt" && is_file(folder / "rgb.txt"))
      return span_of_recording(folder.string(), {});
  } catch (const Error&) {
    // A recording whose images are missing still has its ground truth.
  }
  return std::nullopt;
}

/// Ground truth is often longer than the recording: an estimate cannot have poses without frames. False: none is
/// within.
bool keep_span(TrajectoryInput& input, const StampSpan& span, std::string& said) {
  constexpr TimeNs slack = 20'000'000;
  TrajectoryInput kept = input;
  kept.poses.clear();
  kept.matrices.clear();
  for (std::size_t k = 0; k < input.poses.size(); ++k) {
    if (input.poses[k].stamp < span.first - slack || input.poses[k].stamp > span.last + slack) continue;
    kept.poses.push_back(input.poses[k]);
    kept.matrices.push_back(input.matrices[k]);
  }
  if (kept.poses.empty() || kept.poses.size() == input.poses.size()) return !kept.poses.empty();
  said += fmt::format("; only the {} of {} that lie within the recording", kept.poses.size(), input.poses.size());
  input = std::move(kept);
  return true;
}

/// A single file gives its poses with all their digits; KITTI's lie apart from their stamps (poses/00.txt).
TrajectoryInput ground_truth_of(const SourceInfo& info, const std::string& times) {
  TrajectoryInput of_recording = trajectory_input_from(info.ground_truth, info.ground_truth_file);
  if (!is_file(info.ground_truth_file)) return of_recording;
  TrajectoryInput of_file = read_trajectory_input(info.ground_truth_file, times);
  if (of_file.has_stamps || !info.has_stamps) return of_file;
  if (of_file.poses.size() != of_recording.poses.size()) return of_recording;
  of_file.poses = std::move(of_recording.poses);
  of_file.has_stamps = true;
  of_file.stamps_from = of_recording.stamps_from;
  return of_file;
}

Found read_recording(const std::string& path, const std::string& times) {
  const auto source = open(path);
  const SourceInfo& info = source->info();
  if (info.ground_truth.empty())
    throw Error("has no ground truth", path, "give a trajectory file, or a recording with ground truth");
  Found found;
  found.input = ground_truth_of(info, times);
  found.of_body = info.ground_truth_frame == "body";
  found.compare_in_body = info.format == "kitti_raw";
  found.recording = found.input.format == TrajectoryFormat::kitti ? std::nullopt : span_of_recording(path, {});
  if (info.cameras.empty()) return found;  // a laser's
  const CalibratedCamera& camera = info.cameras.front();
  if (camera.body_from_camera) found.mount = CameraMount{*camera.body_from_camera, camera.calibration_file};
  return found;
}

Found find_reference(const std::string& path, const std::string& times) {
  if (is_folder(path) && !is_file(fs::path(path) / "trajectory.txt")) return read_recording(path, times);
  Found found;
  found.input = read_trajectory_input(is_folder(path) ? (fs::path(path) / "trajectory.txt").string() : path, times);
  found.of_body = found.input.format == TrajectoryFormat::euroc;
  if (found.of_body) found.mount = mount_beside(path);
  if (found.input.format != TrajectoryFormat::kitti) found.recording = span_beside(path);
  return found;
}

void move_poses(TrajectoryInput& input, const SE3& left, const SE3& right) {
  for (StampedPose& pose : input.poses) pose.world_from_body = left * pose.world_from_body * right;
  for (Eigen::Matrix4d& pose : input.matrices) pose = (left.matrix() * pose * right.matrix()).eval();
}

bool starts_at_identity(const TrajectoryInput& input) {
  const SE3& first = input.poses.front().world_from_body;
  return first.rotation().log().norm() < 1e-3 && first.translation().norm() < 1e-3;
}

/// Of the reference, those of some frames.
void keep_frames(TrajectoryInput& input, const std::string& path, const std::string& frames, std::string& said) {
  OpenOptions options;
  set_frames(frames, options);
  if (!input.has_stamps) throw Error("has no timestamps, so its frames are unknown", path, "omit --frames");
  fs::path recording = path;
  if (!is_folder(path)) recording = recording.parent_path();
  if (recording.filename() == "state_groundtruth_estimate0") recording = recording.parent_path();
  const auto span = span_of_recording(recording.empty() ? "." : recording.string(), options);
  if (!span || !keep_span(input, *span, said))
    throw Error(fmt::format("has no pose at frames {}", frames), path, "omit --frames");
}

void require_known(const std::string& estimate_of) {
  if (estimate_of.empty() || estimate_of == "camera" || estimate_of == "body") return;
  throw Error(in_quotes(estimate_of) + " is not camera or body", "--estimate-of", "give one of them");
}

}  // namespace

std::optional<StampSpan> span_of_recording(const std::string& path, OpenOptions options) {
  options.read_ahead = 0;
  options.want_color = options.want_depth = options.want_right = false;
  const auto chosen = open(path, options);
  const std::int64_t end = std::min(options.end_frame, chosen->info().frame_count);
  if (end <= options.first_frame || !chosen->info().has_stamps) return std::nullopt;
  options.first_frame += (end - 1 - options.first_frame) / options.every * options.every;
  const auto first = chosen->next(), last = open(path, options)->next();
  if (!first || !last) return std::nullopt;
  return StampSpan{first->stamp, last->stamp};
}

ReferenceTrajectory read_reference(const std::string& path, const TrajectoryFileFlags& flags) {
  require_known(flags.estimate_of);
  Found found = find_reference(path, flags.times);
  if (!flags.body_from_camera.empty()) {
    found.mount = given_mount(flags.body_from_camera);
    found.of_body = true;
  }
  ReferenceTrajectory reference;
  reference.input = std::move(found.input);
  const bool by_camera = found.of_body && flags.estimate_of != "body";
  if (by_camera && !found.mount && flags.estimate_of == "camera")
    throw Error("is of the body, and the pose of the camera on it is unknown", path,
                "give --body-from-camera FILE (a sensor.yaml with T_BS), or --estimate-of body");
  if (by_camera && found.mount && found.compare_in_body) {
    reference.frames = "of the body; the camera poses of the estimate are converted with T_BS of " + found.mount->from;
    reference.body_from_camera_of_estimates = found.mount->body_from_camera;
    reference.of_body = true;
  } else if (by_camera && found.mount) {
    reference.frames = "of the body, converted to poses of the camera with T_BS of " + found.mount->from;
    move_poses(reference.input, SE3(), found.mount->body_from_camera);
  } else {
    reference.of_body = found.of_body;
    reference.frames = found.of_body ? "of the body; the estimate is compared as it is" : "compared as they are";
  }
  if (!flags.frames.empty())
    keep_frames(reference.input, path, flags.frames, reference.frames);
  else if (found.recording)
    keep_span(reference.input, *found.recording, reference.frames);
  reference.camera_world =
      !reference.of_body && (reference.input.format == TrajectoryFormat::kitti || starts_at_identity(reference.input));
  return reference;
}

Trajectory poses_of_camera(const ReferenceTrajectory& reference) {
  Trajectory of_camera = reference.input.poses;
  if (const auto& mount = reference.body_from_camera_of_estimates)
    for (StampedPose& pose : of_camera) pose.world_from_body = pose.world_from_body * *mount;
  return of_camera;
}

TrajectoryInput read_estimate(const std::string& path, const ReferenceTrajectory& reference,
                              const TrajectoryFileFlags& flags) {
  std::string file = path;
  if (is_folder(path)) {
    file = (fs::path(path) / "trajectory.txt").string();
    if (!is_file(file)) throw Error("has no trajectory.txt", path, "give a run folder or a file");
  }
  TrajectoryInput input = read_trajectory_input(file, flags.times);
  if (const auto& mount = reference.body_from_camera_of_estimates) move_poses(input, *mount, mount->inverse());
  return input;
}

PoseConsistency consistency_of_run(const std::string& path, const ReferenceTrajectory& reference,
                                   const TrajectoryInput& final_poses, double scale, TimeNs max_difference) {
  const fs::path covariance_file = fs::path(path) / "covariance_online.txt";
  const fs::path first_poses_file = fs::path(path) / "trajectory_online.txt";
  if (!is_folder(path) || !is_file(covariance_file) || !is_file(first_poses_file)) return {};
  auto covariances = parse_pose_covariances(read_text_file(covariance_file.string()), covariance_file.string());
  // The rotation error times the distance from camera to body is not added: it is small beside the position's.
  if (const auto& mount = reference.body_from_camera_of_estimates) {
    Matrix6d turned = Matrix6d::Zero();
    turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = mount->rotation().matrix();
    for (StampedCovariance& each : covariances)
      each.covariance = (turned * each.covariance * turned.transpose()).eval();
  }
  const TrajectoryInput first_poses = read_estimate(first_poses_file.string(), reference, {});
  return score_consistency(
      {reference.input.poses, final_poses.poses, first_poses.poses, covariances, scale, max_difference});
}

}  // namespace rastro::cli
