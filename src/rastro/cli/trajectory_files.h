// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "rastro/dataset/open.h"
#include "rastro/evaluate/pose_consistency.h"
#include "rastro/evaluate/trajectory_input.h"
#include "rastro/math/se3.h"

namespace rastro::cli {

/// First and last stamp of the frames of a recording.
struct StampSpan {
  TimeNs first = 0, last = 0;
};

/// Of the frames that the options choose; nullopt where there are none, or no stamps.
std::optional<StampSpan> span_of_recording(const std::string& path, OpenOptions options);

struct TrajectoryFileFlags {
  std::string times;             ///< --times FILE: stamps of KITTI poses.
  std::string estimate_of;       ///< --estimate-of camera|body; empty: detected.
  std::string body_from_camera;  ///< --body-from-camera FILE.
  std::string frames;            ///< --frames A:B of the recording that the reference is or lies in; empty: all.
};

/// A reference, ready to be compared with the estimates.
struct ReferenceTrajectory {
  TrajectoryInput input;
  std::string frames;  ///< What its poses are of, and after which conversion; one clause.
  bool of_body = false;
  bool camera_world = false;  ///< The world is the first camera: x right, y down.
  /// Converts estimates of the camera to the body, where they are compared there (KITTI raw).
  std::optional<SE3> body_from_camera_of_estimates;
};

/// A trajectory file, a run folder (its trajectory.txt) or a recording with ground truth. A reference of the body is
/// converted to one of the camera where the estimate is the camera's and T_BS is known: from --body-from-camera, the
/// recording, or ../cam0/sensor.yaml beside EuRoC's state_groundtruth_estimate0/data.csv. Only KITTI raw is compared in
/// the frame of its IMU. Where the reference lies in a EuRoC or TUM recording, its poses before the first frame and
/// after the last one are omitted, with --frames of any recording. Error for what cannot be read, for --estimate-of
/// camera without a T_BS, and for frames without a pose of the reference.
ReferenceTrajectory read_reference(const std::string& path, const TrajectoryFileFlags& flags);

/// world_from_camera.
Trajectory poses_of_camera(const ReferenceTrajectory& reference);

/// A trajectory file or a run folder.
TrajectoryInput read_estimate(const std::string& path, const ReferenceTrajectory& reference,
                              const TrajectoryFileFlags& flags);

/// Of a run folder with covariance_online.txt: whether the covariances hold. Empty for a file and for a run without.
/// `scale`: units of the reference per unit of the estimate.
PoseConsistency consistency_of_run(const std::string& path, const ReferenceTrajectory& reference,
                                   const TrajectoryInput& final_poses, double scale, TimeNs max_difference);

}  // namespace rastro::cli
