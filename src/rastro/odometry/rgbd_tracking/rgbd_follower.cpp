// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "rastro/base/checked_options.h"
#include "rastro/base/random.h"
#include "rastro/math/median.h"
#include "rastro/multiview/absolute_pose.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/odometry/rgbd_tracking/camera_motion.h"
#include "rastro/odometry/rgbd_tracking/coverage.h"
#include "rastro/odometry/rgbd_tracking/delayed_depth.h"
#include "rastro/odometry/rgbd_tracking/feature_noise.h"
#include "rastro/odometry/rgbd_tracking/feature_tracker.h"
#include "rastro/odometry/rgbd_tracking/followed_points.h"
#include "rastro/odometry/rgbd_tracking/landmark_finder.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"
#include "rastro/odometry/rgbd_tracking/pose_judge.h"
#include "rastro/odometry/rgbd_tracking/pose_solver.h"
#include "rastro/odometry/rgbd_tracking/surface_matcher.h"

namespace rastro {
namespace {

constexpr int most_missed = 20;
// Where fewer of the features agree, there are several motions, and that of most of the image is the camera's.
constexpr double agreeing_share = 0.7;
constexpr int solver_iterations = 6;
// Surfaces: every fourth block for the coarse search, every third for the fine one; search radius in meters.
constexpr int coarse_step = 4, fine_step = 3, coarse_iterations = 12;
constexpr double coarse_reach_m = 0.2, fine_reach_m = 0.03;
// While something moves, surfaces that fit less closely are taken for its own.
constexpr double close_reach_m = 0.01;
constexpr int moving_frames = 10;
// A feature further off than this is not there by an error of calibration or by blur: it moves.
constexpr double moving_px = 10.0;
constexpr double lost_variance = 1.0;
// Share of the last motion, per frame.
constexpr double lost_damping = 0.5;
constexpr int corners_to_find = 600;

bool has_surface(const Reference& reference) {
  return std::any_of(reference.planes.begin(), reference.planes.end(),
                     [](const BlockPlane& plane) { return plane.distance > 0.0F; });
}

}  // namespace

class RgbdFollower::State {
 public:
  State(const RgbdOptions& options, const Camera& camera, TaskPool* pool)
      : options_(checked(options, "odometry options")),
        camera_(camera),
        check_(options_.frame_check),
        tracker_(options_, camera_, pool),
        depth_(options_, camera_),
        points_(options_, camera_),
        surfaces_(options_),
        judge_(options_, camera_.fx) {}

  RgbdFollow follow(const Frame& frame);
  void restart(const SE3& world_from_camera);
  void move(const SE3& new_world_from_world);
  const SE3& world_from_camera() const { return motion_.pose(); }
  std::vector<SE3> reference_poses() const;
  const std::vector<FollowedFeature>& features() const { return features_; }

 private:
  bool map_is_empty() const;
  void start(const Frame& frame, RgbdFollow& result);
  void follow_map(const Frame& frame, bool image_useful, RgbdFollow& result);
  bool find_pose(const Frame& frame, const SE3& guess, bool image_useful, RgbdFollow& result);
  std::optional<SE3> first_pose(const Frame& frame, const SE3& guess, bool image_useful,
                                std::vector<FoundPoint>& carried, RgbdFollow& result);
  std::optional<SE3> pose_from(const std::vector<FoundPoint>& found, const std::vector<std::int32_t>& weights,
                               const SE3& guess, RgbdFollow& result);
  std::optional<SE3> pose_from_surfaces(const Frame& frame, const SE3& guess);
  double leave_out_moving(const SE3& pose);
  void learn_delay(const SE3& pose);
  bool is_reference(const SE3& pose, int inliers) const;
  void add_reference(const Frame& frame, const SE3& pose);
  double add_points(const Frame& frame, int number);

  RgbdOptions options_;
  Camera camera_;
  FrameCheck check_;
  FeatureTracker tracker_;
  DelayedDepth depth_;
  FollowedPoints points_;  ///< Of the last frame.
  FeatureNoise noise_;
  SurfaceMatcher surfaces_;
  PoseJudge judge_;
  LandmarkFinder landmark_finder_;
  PointMap map_;
  CameraMotion motion_;
  SE3 camera_from_depth_;      ///< Between the color and the depth of the last frame.
  int reference_inliers_ = 0;  ///< Inliers of the newest reference.
  std::int64_t followed_ = 0;
  ImageParts moving_;                      ///< Of the last frame, in which something moves.
  std::int64_t moved_until_ = 0;           ///< By `followed_`: so long something may still move before the camera.
  std::vector<FollowedFeature> features_;  ///< Of the last frame, for those who ask.
};

RgbdFollow RgbdFollower::State::follow(const Frame& frame) {
  RgbdFollow result;
  ++followed_;
  features_.clear();
  result.world_from_camera = motion_.pose();
  result.state = map_is_empty() ? OdometryState::initializing : OdometryState::weak;
  const FrameCheckResult image_check = check_.check(frame.image.view(), frame.stamp);
  if (image_check.reason != OdometryReason::repeated_frame && !frame.image.empty()) {
    camera_.width = frame.image.width();  // some calibrations have no size
    camera_.height = frame.image.height();
    // A blurred image still has more information than a prediction.
    const bool image_useful = image_check.useful() || image_check.reason == OdometryReason::blurred;
    if (image_useful) tracker_.take(frame);
    surfaces_.take(frame, camera_);
    if (!map_is_empty())
      follow_map(frame, image_useful, result);
    else if (image_useful)
      start(frame, result);  // else the features would be those of an earlier image
  }
  if (image_check.reason != OdometryReason::none && (result.reason == OdometryReason::none || !image_check.useful())) {
    result.reason = image_check.reason;
    result.detail = image_check.detail;
  }
  if (!map_.references.empty()) result.world_from_reference = map_.references.back().world_from_camera;
  return result;
}

bool RgbdFollower::State::map_is_empty() const { return static_cast<int>(map_.references.size()) == map_.first_live; }

void RgbdFollower::State::start(const Frame& frame, RgbdFollow& result) {
  result.reason = OdometryReason::first_frame;
  if (frame.depth.empty()) {
    result.detail = "has no depth";
    return;
  }
  motion_.restart(motion_.pose());
  motion_.note(frame.stamp, motion_.pose());
  camera_from_depth_ = SE3();  // at rest, as far as is known
  points_.clear();
  add_reference(frame, motion_.pose());
  if (reference_inliers_ == 0 && !has_surface(map_.references.back())) {
    map_.references.pop_back();  // nothing to follow
    result.detail = "has no depth where it is needed";
    return;
  }
  result.state = OdometryState::tracking;
  result.points = result.inliers = reference_inliers_;
  result.inlier_share = 1.0;
  result.new_reference = true;
}

void RgbdFollower::State::follow_map(const Frame& frame, bool image_useful, RgbdFollow& result) {
  const SE3 guess = motion_.predicted(frame.stamp);
  if (!find_pose(frame, guess, image_useful, result)) {
    result.state = OdometryState::lost;
    result.reason = result.points < options_.min_points ? OdometryReason::too_few_points : OdometryReason::few_inliers;
    result.detail = fmt::format("{} of {} points are inliers", result.inliers, result.points);
    result.world_from_camera = guess;
    result.covariance = lost_variance * Matrix6d::Identity();
    motion_.note(frame.stamp, guess);
    for (FollowedFeature& feature : features_) feature.state = FollowedFeature::State::matched;
    motion_.slow_down(lost_damping);
    for (MapPoint& point : map_.points) point.tracked = false;
    return;
  }
  if (image_useful && !frame.depth.empty() && is_reference(result.world_from_camera, result.inliers)) {
    add_reference(frame, result.world_from_camera);
    result.new_reference = true;
  }
  map_.forget(options_.map_references, most_missed);  // indices into the points end here
}

/// Color and depth are taken at different times, and the stamps are often wrong. The apparent motion of depth against
/// color during a rotation shows the delay.
void RgbdFollower::State::learn_delay(const SE3& pose) {
  DelayedQuadratic frame = points_with_delay(points_.measured(), pose);
  frame += surfaces_.compare_with_delay(map_, pose, camera_from_depth_, motion_.velocity(), fine_reach_m, coarse_step);
  const auto [information, gradient] = delay_alone(frame);
  map_.delay_depths(depth_.learn(information, gradient));
}

std::optional<SE3> RgbdFollower::State::pose_from(const std::vector<FoundPoint>& found,
                                                  const std::vector<std::int32_t>& weights, const SE3& guess,
                                                  RgbdFollow& result) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> rays;
  for (const FoundPoint& point : found) {
    points.push_back(map_.in_world(map_.points[point.point]));
    rays.push_back(point.ray);
  }
  AbsolutePoseOptions options;
  options.max_error_px = options_.max_error_px;
  options.max_iterations = options_.ransac_iterations;
  options.seed = seed_for(options_.seed, static_cast<std::uint64_t>(followed_));
  options.focal_px = camera_.fx;
  result.points = static_cast<int>(found.size());
  auto pose = estimate_absolute_pose(points, rays, options, guess.inverse());
  if (!pose || pose->inliers < agreeing_share * result.points)
    pose = estimate_absolute_pose(points, rays, options, guess.inverse(), weights);
  result.inliers = pose ? pose->inliers : 0;
  result.inlier_share = pose ? weighted_share(weights, pose->is_inlier) : 0.0;
  if (!judge_.features_fit(result)) return std::nullopt;
  return pose->camera_from_world.inverse();
}

/// A pose good enough to guide the search for everything else: from the features of the previous frame, else from those
/// of any reference, else from surfaces.
std::optional<SE3> RgbdFollower::State::first_pose(const Frame& frame, const SE3& guess, bool image_useful,
                                                   std::vector<FoundPoint>& carried, RgbdFollow& result) {
  if (image_useful) {
    carried = tracker_.carry_on(map_, guess);
    if (auto pose = pose_from(carried, coverage_weights(carried, camera_), guess, result)) return pose;
  }
  if (auto pose = pose_from_surfaces(frame, guess)) return pose;
  if (!image_useful) return std::nullopt;
  carried.clear();
  const std::vector<FoundPoint> anywhere =
      landmark_finder_.find(map_, camera_, tracker_.pyramid(), tracker_.new_corners(frame, {}, corners_to_find));
  // What does not fit here is matched wrongly, anywhere in the image.
  return pose_from(anywhere, std::vector<std::int32_t>(anywhere.size(), 1), guess, result);
}

std::optional<SE3> RgbdFollower::State::pose_from_surfaces(const Frame& frame, const SE3& guess) {
  SE3 pose = guess;
  const SE3 camera_from_depth = depth_.depth_from_color(frame, motion_.velocity_to(frame.stamp, guess)).inverse();
  surfaces_.choose(map_, pose, camera_from_depth);
  SurfaceMatch match;
  PoseQuadratic last;
  for (int i = 0; i < coarse_iterations; ++i) {
    match = {};
    const double reach_m = std::max(fine_reach_m, coarse_reach_m * (1.0 - static_cast<double>(i) / coarse_iterations));
    last = surfaces_.compare(map_, pose, camera_from_depth, reach_m, coarse_step, &match);
    const Vector6d step = (last.information + Matrix6d::Identity()).ldlt().solve(last.gradient);
    if (!step.allFinite() || step.norm() > coarse_reach_m) return std::nullopt;
    pose = pose * SE3::exp(step);
  }
  if (!match.fits()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(last.information, Eigen::EigenvaluesOnly);
  if (eigen.eigenvalues()(0) < 1.0 / (options_.weak_sigma * options_.weak_sigma)) return std::nullopt;
  return pose;
}

bool RgbdFollower::State::find_pose(const Frame& frame, const SE3& guess, bool image_useful, RgbdFollow& result) {
  std::vector<FoundPoint> carried;
  const auto first = first_pose(frame, guess, image_useful, carried, result);
  if (!first) {
    for (const FoundPoint& point : carried) features_.push_back({point.pixel, FollowedFeature::State::matched});
    return false;
  }
  points_.take(image_useful ? tracker_.recognize(map_, *first, carried) : std::vector<FoundPoint>(), map_,
               noise_.factor());
  // Depth readings depend on the pose at which the depth was taken, which is known now.
  const Vector6d velocity = motion_.velocity_to(frame.stamp, *first);
  const SE3 camera_from_depth = depth_.depth_from_color(frame, velocity).inverse();
  points_.read_depths(frame, velocity, depth_);
  const double reach_m = leave_out_moving(*first);
  surfaces_.choose(map_, *first, camera_from_depth);
  const PoseSolution solution = solve_pose(
      points_.measured(), options_.shared_error_px / camera_.fx, *first, solver_iterations,
      [&](const SE3& pose, int) { return surfaces_.compare(map_, pose, camera_from_depth, reach_m, fine_step); });
  SurfaceMatch match;
  surfaces_.compare(map_, solution.world_from_camera, camera_from_depth, reach_m, coarse_step, &match);
  result.points = static_cast<int>(points_.measured().size());
  const PoseJudge::ExcessVariance excess = judge_.excess_variance(points_.measured(), solution, noise_.factor());
  if (static_cast<int>(points_.measured().size()) >= options_.min_points)
    noise_.learn(variance_ratio(points_.measured(), solution.by_points_alone()));
  result.inlier_share = points_.keep_inliers(solution.by_points_alone(), map_, features_);
  result.inliers = static_cast<int>(points_.found().size());
  if (!judge_.judge(solution, match, map_.references.back(), excess, result)) return false;
  motion_.note(frame.stamp, solution.world_from_camera);
  camera_from_depth_ = camera_from_depth;
  if (options_.learn_delay) learn_delay(solution.world_from_camera);
  points_.teach_depths(solution.world_from_camera, map_);
  return true;
}

/// Leaves out the surfaces of what moves before the rest, whose motion is `pose`. Returns how closely the others must
/// fit.
double RgbdFollower::State::leave_out_moving(const SE3& pose) {
  moving_ = moving_parts(points_.found(), points_.fitting(pose, moving_px), camera_);
  if (moving_.any()) moved_until_ = followed_ + moving_frames;
  surfaces_.leave_out(moving_);
  return followed_ <= moved_until_ ? close_reach_m : fine_reach_m;
}

bool RgbdFollower::State::is_reference(const SE3& pose, int inliers) const {
  if (inliers < options_.min_reference_share * reference_inliers_) return true;
  const int oldest = std::max(map_.first_live, static_cast<int>(map_.references.size()) - options_.map_references);
  for (std::size_t i = static_cast<std::size_t>(oldest); i < map_.references.size(); ++i) {
    const Reference& reference = map_.references[i];
    const SE3 motion = reference.world_from_camera.inverse() * pose;
    const double rotation_deg = motion.rotation().log().norm() * 180.0 / std::numbers::pi;
    if (rotation_deg < options_.max_reference_rotation_deg &&
        motion.translation().norm() < options_.max_reference_motion_m * reference.median_depth)
      return false;
  }
  return true;
}

void RgbdFollower::State::add_reference(const Frame& frame, const SE3& pose) {
  const int number = static_cast<int>(map_.references.size());
  Reference reference;
  reference.stamp = frame.stamp;
  reference.world_from_camera = pose;
  surfaces_.keep(reference, camera_from_depth_, motion_.velocity());
  map_.references.push_back(std::move(reference));
  map_.references.back().median_depth = add_points(frame, number);
}

/// New points of the newest reference; returns the median depth of its image.
double RgbdFollower::State::add_points(const Frame& frame, int number) {
  const int wanted = options_.features - static_cast<int>(points_.found().size());
  std::vector<double> depths;
  for (const PointMeasurement& measured : points_.measured()) {
    if (measured.inverse_depth > 0.0) depths.push_back(1.0 / measured.inverse_depth);
  }
  const std::vector<Eigen::Vector2f> corners = tracker_.new_corners(frame, points_.found(), 2 * wanted);
  const std::vector<Descriptor> descriptors = landmark_finder_.describe(tracker_.pyramid(), corners);
  int added = 0;
  for (std::size_t i = 0; i < corners.size() && added < wanted; ++i) {
    if (moving_.at(static_cast<int>(corners[i].x()), static_cast<int>(corners[i].y()))) continue;
    const auto ray = camera_.unproject(corners[i].cast<double>());
    const auto reading = ray ? depth_.read(frame, *ray, motion_.velocity()) : std::nullopt;
    if (!reading) continue;
    MapPoint point;
    point.anchor = number;
    point.ray = *ray;
    point.inverse_depth = reading->inverse_depth;
    PointMap::add_reading(point, *reading);
    point.patch.keep(tracker_.pyramid(), corners[i], options_.patch_px);
    point.descriptor = descriptors[i];
    point.pixel = corners[i];
    point.tracked = true;
    map_.points.push_back(std::move(point));
    features_.push_back({corners[i], FollowedFeature::State::fresh});
    depths.push_back(1.0 / reading->inverse_depth);
    ++added;
  }
  reference_inliers_ = static_cast<int>(points_.found().size()) + added;
  return upper_median_or(std::move(depths), 1.0);
}

void RgbdFollower::State::restart(const SE3& world_from_camera) {
  map_.first_live = static_cast<int>(map_.references.size());
  map_.points.clear();
  motion_.restart(world_from_camera);
  points_.clear();
  moving_ = {};
  check_.forget_last();
}

void RgbdFollower::State::move(const SE3& new_world_from_world) {
  for (Reference& reference : map_.references)
    reference.world_from_camera = new_world_from_world * reference.world_from_camera;
  motion_.move(new_world_from_world);
}

std::vector<SE3> RgbdFollower::State::reference_poses() const {
  std::vector<SE3> poses;
  for (const Reference& reference : map_.references) poses.push_back(reference.world_from_camera);
  return poses;
}

RgbdFollower::RgbdFollower(const RgbdOptions& options, const Camera& camera, TaskPool* pool)
    : state_(std::make_unique<State>(options, camera, pool)) {}
RgbdFollower::~RgbdFollower() = default;
RgbdFollow RgbdFollower::follow(const Frame& frame) { return state_->follow(frame); }
void RgbdFollower::restart(const SE3& world_from_camera) { state_->restart(world_from_camera); }
void RgbdFollower::move(const SE3& new_world_from_world) { state_->move(new_world_from_world); }
const SE3& RgbdFollower::world_from_camera() const { return state_->world_from_camera(); }
const std::vector<FollowedFeature>& RgbdFollower::features() const { return state_->features(); }
std::vector<SE3> RgbdFollower::reference_poses() const { return state_->reference_poses(); }

}  // namespace rastro
