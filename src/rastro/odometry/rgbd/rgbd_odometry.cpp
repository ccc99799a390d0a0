// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd/rgbd_odometry.h"

#include <algorithm>

#include "rastro/base/stopwatch.h"
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"

namespace rastro {
namespace {

// The view may return after a jolt. After this many frames without any match, a new local map is better.
constexpr int most_lost_frames = 30;

}  // namespace

class RgbdOdometry::State {
 public:
  State(const RgbdOptions& options, const Camera& camera, TaskPool* pool) : follower(options, camera, pool) {}

  RgbdFollower follower;
  struct Record {
    TimeNs stamp;
    int reference;  ///< Index of the newest reference frame at that time.
    SE3 reference_from_camera;
  };
  std::vector<Record> records;
  int reference = -1;  ///< Index of the newest.
  int lost = 0;
};

RgbdOdometry::RgbdOdometry(const RgbdOptions& options, const Camera& camera, TaskPool* pool)
    : state_(std::make_unique<State>(options, camera, pool)) {}
RgbdOdometry::~RgbdOdometry() = default;

OdometryUpdate RgbdOdometry::process(const Frame& frame) {
  Stopwatch stopwatch;
  if (state_->lost >= most_lost_frames) {
    state_->follower.restart(state_->follower.world_from_camera());
    state_->lost = 0;
  }
  const RgbdFollow follow = state_->follower.follow(frame);
  state_->lost = follow.state == OdometryState::lost ? state_->lost + 1 : 0;
  OdometryUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  update.state = follow.state;
  update.reason = follow.reason;
  update.detail = follow.detail;
  update.world_from_camera = follow.world_from_camera;
  update.used = follow.state == OdometryState::tracking;
  update.matches = follow.points;
  update.inliers = follow.inliers;
  update.confidence = follow.points > 0 ? follow.inlier_share : 0.0;
  if (follow.new_reference) ++state_->reference;
  state_->records.push_back(
      {frame.stamp, state_->reference, follow.world_from_reference.inverse() * follow.world_from_camera});
  update.milliseconds = stopwatch.lap_ms();
  return update;
}

Trajectory RgbdOdometry::trajectory() const {
  const std::vector<SE3> references = state_->follower.reference_poses();
  Trajectory trajectory;
  for (const State::Record& record : state_->records) {
    const SE3 world_from_reference =
        record.reference < 0 ? SE3() : references[static_cast<std::size_t>(record.reference)];
    trajectory.push_back({record.stamp, world_from_reference * record.reference_from_camera});
  }
  return trajectory;
}

std::vector<OdometryFeature> RgbdOdometry::features() const {
  using From = FollowedFeature::State;
  using To = OdometryFeature::State;
  std::vector<OdometryFeature> features;
  for (const FollowedFeature& seen : state_->follower.features()) {
    const To state = seen.state == From::inlier    ? To::inlier
                     : seen.state == From::outlier ? To::outlier
                     : seen.state == From::fresh   ? To::fresh
                                                   : To::matched;
    features.push_back({seen.pixel, -1, state});
  }
  return features;
}

}  // namespace rastro
