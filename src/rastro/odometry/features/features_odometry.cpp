// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/features_odometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/checked_options.h"
#include "rastro/base/random.h"
#include "rastro/base/stopwatch.h"
#include "rastro/math/median.h"
#include "rastro/multiview/absolute_pose.h"
#include "rastro/multiview/essential.h"
#include "rastro/multiview/rotation.h"
#include "rastro/odometry/features/feature_source.h"
#include "rastro/odometry/features/local_map.h"
#include "rastro/odometry/features/pose_chain.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/optimize/calibration_check.h"

namespace rastro {

class FeaturesOdometry::State {
 public:
  State(const FeaturesOptions& options, const Camera& camera, TaskPool* pool)
      : options_(checked(options, "odometry options")),
        camera_(camera),
        focal_px_(camera.fx),
        features_(make_feature_source(options_, camera, pool)),
        map_(options_, focal_px_),
        calibration_(options_.calibration_tolerance) {}

  OdometryUpdate process(const Frame& frame);
  Trajectory trajectory() const;
  std::vector<OdometryFeature> features() const;

 private:
  /// A frame waiting for initialization.
  struct Waiting {
    std::size_t record;
    TimeNs stamp;
    RayObservations observations;
  };

  void start(OdometryUpdate& update, const RayObservations& observations);
  void thin_out_waiting();
  bool start_from_pair(OdometryUpdate& update, const Waiting& first, const Waiting& second);
  void locate_waiting(std::size_t first_keyframe);
  void follow(OdometryUpdate& update, const RayObservations& observations);
  bool stands_still(OdometryUpdate& update, const RayObservations& observations);
  std::optional<AbsolutePose> pose_from_points(const RayObservations& observations, const SE3& guess,
                                               OdometryUpdate& update);
  bool is_keyframe(const RayObservations& observations, const SE3& camera_from_world, int inliers) const;
  void add_keyframe(OdometryUpdate& update, const RayObservations& observations);
  void check_calibration();
  void bridge(OdometryUpdate& update);
  void restart(const OdometryUpdate& update, const RayObservations& observations);
  CalibratedRansacOptions ransac(double max_error_px) const;
  SE3 keyframe_pose(std::size_t keyframe) const { return map_.keyframes()[keyframe].camera_from_world; }

  FeaturesOptions options_;
  Camera camera_;
  double focal_px_;
  std::unique_ptr<FeatureSource> features_;
  FrameCheck check_;
  LocalMap map_;
  PoseChain chain_;
  CalibrationCheck calibration_;
  std::size_t next_calibration_check_ = 0;
  std::vector<Waiting> waiting_;
  bool started_ = false;
  RayObservations moved_observations_;  ///< Of the last frame that moved.
  RayObservations seen_;                ///< Of the last frame.
  std::int64_t newest_id_ = -1;         ///< Of the frames before it.
  std::int64_t processed_ = 0;
};

OdometryUpdate FeaturesOdometry::State::process(const Frame& frame) {
  Stopwatch stopwatch;
  OdometryUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  ++processed_;
  if (!seen_.empty()) newest_id_ = seen_.back().id;
  seen_.clear();
  const FrameCheckResult image_check = check_.check(frame.image.view(), frame.stamp);
  if (image_check.useful()) {
    const RayObservations observations = features_->next(frame);
    seen_ = observations;
    started_ ? follow(update, observations) : start(update, observations);
    // Against the last frame that moved; otherwise a slow motion would never be detected.
    if (update.reason != OdometryReason::no_motion) moved_observations_ = observations;
    if (image_check.reason != OdometryReason::none && update.reason == OdometryReason::none) {
      update.reason = image_check.reason;
      update.detail = image_check.detail;
      if (update.state == OdometryState::tracking) update.state = OdometryState::weak;
    }
    if (update.state == OdometryState::tracking && update.reason == OdometryReason::none && calibration_.doubtful()) {
      update.reason = OdometryReason::calibration_doubtful;
      update.detail = calibration_.detail(focal_px_);
    }
  } else {
    update.used = false;
    update.state = started_ ? OdometryState::weak : OdometryState::initializing;
    update.reason = image_check.reason;
    update.detail = image_check.detail;
    update.reason == OdometryReason::repeated_frame ? chain_.add_repeated(frame.stamp)
                                                    : chain_.add_unknown(frame.stamp);
  }
  update.world_from_camera = chain_.last_camera_from_world(map_).inverse();
  update.milliseconds = stopwatch.lap_ms();
  return update;
}

CalibratedRansacOptions FeaturesOdometry::State::ransac(double max_error_px) const {
  CalibratedRansacOptions options;
  options.max_error_px = max_error_px;
  options.max_iterations = options_.ransac_iterations;
  options.seed = seed_for(options_.seed, static_cast<std::uint64_t>(processed_));
  options.focal_px = focal_px_;
  return options;
}

/// Waits for a pair of frames with enough parallax: the oldest that still shares enough points, and the newest.
void FeaturesOdometry::State::start(OdometryUpdate& update, const RayObservations& observations) {
  update.state = OdometryState::initializing;
  const std::size_t record = chain_.add_unknown(update.stamp);
  waiting_.push_back({record, update.stamp, observations});
  if (waiting_.size() == 1) {
    update.reason = OdometryReason::first_frame;
    return;
  }
  while (waiting_.size() > 2 && static_cast<int>(shared_rays(waiting_.front().observations, observations).a.size()) <
                                    std::max(options_.min_start_points, options_.features / 4)) {
    waiting_.erase(waiting_.begin());
  }
  thin_out_waiting();
  if (start_from_pair(update, waiting_.front(), waiting_.back())) {
    started_ = true;
    waiting_.clear();
    update.state = OdometryState::tracking;
    update.reason = OdometryReason::none;
  }
}

/// A camera that stands still for long needs no pose of every frame: what is left out is interpolated.
void FeaturesOdometry::State::thin_out_waiting() {
  constexpr std::size_t most = 300;
  if (waiting_.size() <= most) return;
  std::vector<Waiting> kept;
  for (std::size_t k = 0; k < waiting_.size(); ++k)
    if (k % 2 == 0 || k + 1 == waiting_.size()) kept.push_back(std::move(waiting_[k]));
  waiting_ = std::move(kept);
}

bool FeaturesOdometry::State::start_from_pair(OdometryUpdate& update, const Waiting& first, const Waiting& second) {
  const SharedRays shared = shared_rays(first.observations, second.observations);
  update.matches = static_cast<int>(shared.a.size());
  const auto refuse = [&](OdometryReason reason, std::string detail) {
    update.reason = reason;
    update.detail = std::move(detail);
    return false;
  };
  if (update.matches < options_.min_start_points) {
    return refuse(OdometryReason::too_few_points,
                  fmt::format("{} matches, need {}", update.matches, options_.min_start_points));
  }
  const double motion_px = median_motion_px(shared, focal_px_);
  if (motion_px < options_.min_motion_px)
    return refuse(OdometryReason::no_motion, fmt::format("median motion {:.2f} px", motion_px));
  const auto rotation = rotation_between(shared.a, shared.b, ransac(options_.max_error_px));
  if (rotation && rotation->median_error_px < options_.max_error_px) {
    return refuse(rotation->second_from_first.log().norm() * focal_px_ > 2.0 * options_.max_error_px
                      ? OdometryReason::pure_rotation
                      : OdometryReason::too_little_parallax,
                  fmt::format("{:.2f} px beyond the rotation", rotation->median_error_px));
  }
  CalibratedRansacOptions options = ransac(options_.max_error_px);
  options.min_iterations = 200;  // all follows from this motion
  const auto fit = estimate_essential(shared.a, shared.b, options);
  const int needed = static_cast<int>(options_.min_start_inlier_share * update.matches);
  update.inliers = fit ? fit->in_front : 0;
  if (!fit || fit->in_front < needed)
    return refuse(OdometryReason::few_inliers, fmt::format("{} inliers, need {}", update.inliers, needed));
  if (fit->median_parallax_deg < options_.min_start_parallax_deg) {
    return refuse(OdometryReason::too_little_parallax,
                  fmt::format("median parallax {:.2f} deg, need {:.2f}", fit->median_parallax_deg,
                              options_.min_start_parallax_deg));
  }
  const SE3 base = chain_.camera_from_world_at(first.stamp, map_);
  // After tracking was lost, the speed before it gives the scale.
  const double length = chain_.length_between(first.stamp, second.stamp, map_).value_or(1.0);
  const SE3 second_from_first(fit->second_from_first.rotation(), length * fit->second_from_first.translation());
  const std::size_t keyframe = map_.add_keyframe(first.stamp, base, first.observations);
  map_.add_keyframe(second.stamp, second_from_first * base, second.observations);
  if (map_.triangulate() < options_.min_points) {
    map_.restart();
    return refuse(OdometryReason::too_few_points, "too few points could be triangulated");
  }
  map_.drop_bad_points();
  locate_waiting(keyframe);
  return true;
}

/// Poses of the frames between the first pair, from the map points.
void FeaturesOdometry::State::locate_waiting(std::size_t first_keyframe) {
  const TimeNs begin = map_.keyframes()[first_keyframe].stamp, end = map_.keyframes()[first_keyframe + 1].stamp;
  chain_.set(waiting_.front().record, first_keyframe, SE3());
  chain_.set(waiting_.back().record, first_keyframe + 1, SE3());
  for (std::size_t i = 1; i + 1 < waiting_.size(); ++i) {
    const double fraction =
        static_cast<double>(waiting_[i].stamp - begin) / std::max(1.0, static_cast<double>(end - begin));
    const SE3 guess = interpolate(keyframe_pose(first_keyframe), keyframe_pose(first_keyframe + 1), fraction);
    OdometryUpdate ignored;
    const auto pose = pose_from_points(waiting_[i].observations, guess, ignored);
    if (pose)
      chain_.set(waiting_[i].record, first_keyframe, pose->camera_from_world * keyframe_pose(first_keyframe).inverse());
  }
}

std::optional<AbsolutePose> FeaturesOdometry::State::pose_from_points(const RayObservations& observations,
                                                                      const SE3& guess, OdometryUpdate& update) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (const RayObservation& observation : observations) {
    const auto point = map_.points().find(observation.id);
    if (point == map_.points().end()) continue;
    points.push_back(point->second);
    rays.push_back(observation.ray);
  }
  update.matches = static_cast<int>(points.size());
  AbsolutePoseOptions options;
  static_cast<CalibratedRansacOptions&>(options) = ransac(options_.max_error_px);
  options.huber_px = options_.huber_px;
  auto pose = estimate_absolute_pose(points, rays, options, guess);
  update.inliers = pose ? pose->inliers : 0;
  update.confidence = update.matches > 0 ? static_cast<double>(update.inliers) / update.matches : 0.0;
  if (!pose || pose->inliers < options_.min_points || 2 * pose->inliers < update.matches) return std::nullopt;
  return pose;
}

void FeaturesOdometry::State::follow(OdometryUpdate& update, const RayObservations& observations) {
  update.state = OdometryState::tracking;
  if (stands_still(update, observations)) return;
  const SE3 guess = chain_.predicted(update.stamp, map_);
  const auto pose = pose_from_points(observations, guess, update);
  if (!pose) {
    bridge(update);
    restart(update, observations);
    return;
  }
  const std::size_t last = map_.keyframes().size() - 1;
  chain_.add(update.stamp, last, pose->camera_from_world * keyframe_pose(last).inverse());
  if (is_keyframe(observations, pose->camera_from_world, pose->inliers)) add_keyframe(update, observations);
}

bool FeaturesOdometry::State::stands_still(OdometryUpdate& update, const RayObservations& observations) {
  const SharedRays shared = shared_rays(moved_observations_, observations);
  if (static_cast<int>(shared.a.size()) < options_.min_points) return false;
  const double motion_px = median_motion_px(shared, focal_px_);
  // Below the measurement noise of a feature: no motion can be claimed.
  if (motion_px >= 0.5 * options_.min_motion_px) return false;
  update.reason = OdometryReason::no_motion;
  update.detail = fmt::format("median motion {:.2f} px", motion_px);
  update.matches = static_cast<int>(shared.a.size());
  chain_.repeat(update.stamp);
  return true;
}

bool FeaturesOdometry::State::is_keyframe(const RayObservations& observations, const SE3& camera_from_world,
                                          int inliers) const {
  if (inliers < options_.min_keyframe_share * static_cast<double>(observations.size())) return true;
  const LocalMap::Keyframe& keyframe = map_.keyframes().back();
  const SO3 current_from_keyframe = camera_from_world.rotation() * keyframe.camera_from_world.rotation().inverse();
  std::vector<double> motions;
  for (const RayObservation& observation : observations) {
    const Eigen::Vector2d* ray = find_ray(keyframe.observations, observation.id);
    if (!ray) continue;
    const Eigen::Vector3d rotated = current_from_keyframe * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
    if (rotated.z() > 0.0) motions.push_back(focal_px_ * (observation.ray - rotated.head<2>() / rotated.z()).norm());
  }
  return upper_median_or(std::move(motions), 0.0) > options_.keyframe_parallax_px;
}

void FeaturesOdometry::State::add_keyframe(OdometryUpdate& update, const RayObservations& observations) {
  const std::size_t keyframe = map_.add_keyframe(update.stamp, chain_.last_camera_from_world(map_), observations);
  chain_.set_last(keyframe, SE3());
  map_.triangulate();
  if (options_.refine) map_.refine();
  map_.drop_bad_points();
  if (options_.refine) check_calibration();
}

/// Only of windows that share at most one keyframe, so that each is new evidence.
void FeaturesOdometry::State::check_calibration() {
  if (!map_.window_is_full() || map_.keyframes().size() < next_calibration_check_) return;
  next_calibration_check_ = map_.keyframes().size() + static_cast<std::size_t>(options_.window_keyframes) - 1;
  std::vector<std::int64_t> ids;
  calibration_.add(map_.window(ids));
}

/// No pose could be estimated: repeats the last motion.
void FeaturesOdometry::State::bridge(OdometryUpdate& update) {
  update.state = OdometryState::lost;
  const bool few = update.matches < options_.min_points;
  update.reason = few ? OdometryReason::too_few_points : OdometryReason::few_inliers;
  update.detail = few ? fmt::format("{} map points observed, need {}", update.matches, options_.min_points)
                      : fmt::format("{} of {} points are inliers", update.inliers, update.matches);
}

/// Initializes again from this frame, with the predicted pose and speed.
void FeaturesOdometry::State::restart(const OdometryUpdate& update, const RayObservations& observations) {
  map_.restart();
  started_ = false;
  waiting_.clear();
  waiting_.push_back({chain_.add_predicted(update.stamp, map_), update.stamp, observations});
}

Trajectory FeaturesOdometry::State::trajectory() const { return chain_.trajectory(map_); }

std::vector<OdometryFeature> FeaturesOdometry::State::features() const {
  using State = OdometryFeature::State;
  const SE3 camera_from_world = chain_.last_camera_from_world(map_);
  std::vector<OdometryFeature> features;
  for (const RayObservation& seen : seen_) {
    const auto pixel = camera_.project(seen.ray.homogeneous());
    if (!pixel) continue;
    State state = seen.id > newest_id_ ? State::fresh : State::matched;
    const auto point = map_.points().find(seen.id);
    if (started_ && point != map_.points().end()) {
      const Eigen::Vector3d in_camera = camera_from_world * point->second;
      const double error_px = focal_px_ * (in_camera.hnormalized() - seen.ray).norm();
      state = in_camera.z() > 0.0 && error_px <= options_.max_error_px ? State::inlier : State::outlier;
    }
    features.push_back({pixel->cast<float>(), seen.id, state});
  }
  return features;
}

FeaturesOdometry::FeaturesOdometry(const FeaturesOptions& options, const Camera& camera, TaskPool* pool)
    : state_(std::make_unique<State>(options, camera, pool)) {}
FeaturesOdometry::~FeaturesOdometry() = default;
OdometryUpdate FeaturesOdometry::process(const Frame& frame) { return state_->process(frame); }
Trajectory FeaturesOdometry::trajectory() const { return state_->trajectory(); }
std::vector<OdometryFeature> FeaturesOdometry::features() const { return state_->features(); }

}  // namespace rastro
