// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd/rgbd_follower.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "rastro/base/random.h"
#include "rastro/multiview/absolute_pose.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/odometry/rgbd/feature_tracker.h"
#include "rastro/odometry/rgbd/point_map.h"
#include "rastro/odometry/rgbd/pose_solver.h"

namespace rastro {
namespace {

constexpr int most_missed = 20;
constexpr int solver_iterations = 6;
constexpr double most_depth_offset_s = 0.1;
constexpr double first_delay_sigma_s = 0.02, most_delay_s = 0.06, delay_step_s = 0.005;
// Points of one frame err together, and so do frames that follow each other.
constexpr double delay_share = 0.02;
// A point carried on by optical flow alone has drifted since it was first seen.
constexpr double carried_sigma_factor = 2.0;

RgbdOptions checked(RgbdOptions options) {
  RgbdOptions copy = options;
  OptionTable table = option_table(copy);
  for (std::size_t i = 0; i < table.options().size(); ++i)
    table.set(table.options()[i].name, table.value_of(i), "odometry options");
  return options;
}

}  // namespace

class RgbdFollower::State {
 public:
  State(const RgbdOptions& options, const Camera& camera, TaskPool* pool)
      : options_(checked(options)), camera_(camera), check_(options_.frame_check), tracker_(options_, camera_, pool) {}

  RgbdFollow follow(const Frame& frame);
  void restart(const SE3& world_from_camera);
  void move(const SE3& new_world_from_world);
  const SE3& world_from_camera() const { return pose_; }
  std::vector<SE3> reference_poses() const;

 private:
  void follow_useful(const Frame& frame, RgbdFollow& result);
  bool find_pose(const Frame& frame, const SE3& guess, RgbdFollow& result);
  std::optional<SE3> pose_from(const std::vector<FoundPoint>& found, const SE3& guess, RgbdFollow& result);
  std::vector<PointMeasurement> measurements(const Frame& frame, const std::vector<FoundPoint>& found) const;
  SE3 depth_from_colour(const Frame& frame, const Vector6d& velocity, double later_s = 0.0) const;
  std::optional<DepthReading> read(const Frame& frame, const Eigen::Vector2d& ray, const Vector6d& velocity) const;
  void learn_delay(const SE3& pose);
  void learn_depths(const std::vector<FoundPoint>& found, const std::vector<PointMeasurement>& measured,
                    const SE3& pose);
  bool is_reference(const SE3& pose, int inliers) const;
  void add_reference(const Frame& frame, const SE3& pose, const std::vector<FoundPoint>& found);
  SE3 predicted(TimeNs stamp) const;
  Vector6d velocity_to(TimeNs stamp, const SE3& pose) const;
  void note_pose(TimeNs stamp, const SE3& pose);
  double measured_share(const Frame& frame) const;

  RgbdOptions options_;
  Camera camera_;
  FrameCheck check_;
  FeatureTracker tracker_;
  PointMap map_;
  bool has_pose_ = false;
  SE3 pose_;                              ///< world_from_camera of the last frame.
  TimeNs stamp_ = 0;                      ///< Of the last frame.
  Vector6d velocity_ = Vector6d::Zero();  ///< Per second, in the camera.
  double depth_delay_s_ = 0.0;            ///< Learnt: depth was taken so much later than its stamps say.
  double delay_information_ = 1.0 / (first_delay_sigma_s * first_delay_sigma_s);
  int reference_inliers_ = 0;  ///< Points the newest reference could be followed by.
  std::int64_t followed_ = 0;
  std::vector<FoundPoint> found_;
  std::vector<PointMeasurement> measured_;
};

RgbdFollow RgbdFollower::State::follow(const Frame& frame) {
  RgbdFollow result;
  ++followed_;
  const FrameCheckResult look = check_.check(frame.image.view(), frame.stamp);
  result.world_from_camera = pose_;
  if (look.reason == OdometryReason::none || look.reason == OdometryReason::gap ||
      look.reason == OdometryReason::blurred) {
    camera_.width = frame.image.width();  // some calibrations do not say
    camera_.height = frame.image.height();
    tracker_.take(frame);
    follow_useful(frame, result);
  } else {
    result.state = has_pose_ ? OdometryState::weak : OdometryState::initialising;
    velocity_.setZero();
  }
  if (result.reason == OdometryReason::none) {
    result.reason = look.reason;
    result.detail = look.detail;
  }
  if (!map_.references.empty()) result.world_from_reference = map_.references.back().world_from_camera;
  return result;
}

void RgbdFollower::State::follow_useful(const Frame& frame, RgbdFollow& result) {
  if (static_cast<int>(map_.references.size()) == map_.first_live) {
    if (frame.depth.empty()) return;
    result.state = OdometryState::tracking;
    result.reason = OdometryReason::first_frame;
    note_pose(frame.stamp, pose_);
    velocity_.setZero();
    add_reference(frame, pose_, {});
    result.world_from_camera = pose_;
    result.new_reference = true;
    return;
  }
  const SE3 guess = predicted(frame.stamp);
  if (!find_pose(frame, guess, result)) {
    result.state = OdometryState::lost;
    result.reason = result.points < options_.min_points ? OdometryReason::too_few_points : OdometryReason::few_inliers;
    result.detail = fmt::format("{} of {} points agree", result.inliers, result.points);
    result.world_from_camera = guess;
    velocity_ *= 0.5;
    note_pose(frame.stamp, guess);
    return;
  }
  result.state = OdometryState::tracking;
  if (!frame.depth.empty() && is_reference(result.world_from_camera, result.inliers)) {
    add_reference(frame, result.world_from_camera, found_);
    if (options_.window > 0)
      map_.adjust(options_.window, options_.pixel_sigma / camera_.fx, options_.max_error_px / camera_.fx);
    pose_ = result.world_from_camera = map_.references.back().world_from_camera;
    result.new_reference = true;
  }
  map_.forget(options_.map_references, most_missed);  // indices into the points end here
}

SE3 RgbdFollower::State::predicted(TimeNs stamp) const {
  return pose_ * SE3::exp(velocity_ * to_seconds(stamp - stamp_));
}

void RgbdFollower::State::note_pose(TimeNs stamp, const SE3& pose) {
  const double seconds = to_seconds(stamp - stamp_);
  if (has_pose_ && seconds > 0.0) velocity_ = (pose_.inverse() * pose).log() / seconds;
  pose_ = pose;
  stamp_ = stamp;
  has_pose_ = true;
}

Vector6d RgbdFollower::State::velocity_to(TimeNs stamp, const SE3& pose) const {
  const double seconds = to_seconds(stamp - stamp_);
  if (!has_pose_ || seconds <= 0.0) return Vector6d::Zero();
  return (pose_.inverse() * pose).log() / seconds;
}

SE3 RgbdFollower::State::depth_from_colour(const Frame& frame, const Vector6d& velocity, double later_s) const {
  const double offset = to_seconds(frame.depth_stamp - frame.stamp) + depth_delay_s_ + later_s;
  if (std::abs(offset) > most_depth_offset_s) return {};
  return SE3::exp(-offset * velocity);
}

std::optional<DepthReading> RgbdFollower::State::read(const Frame& frame, const Eigen::Vector2d& ray,
                                                      const Vector6d& velocity) const {
  auto reading = read_depth(frame.depth, camera_, ray, depth_from_colour(frame, velocity), options_);
  if (!reading || !options_.learn_delay) return reading;
  const auto later = read_depth(frame.depth, camera_, ray, depth_from_colour(frame, velocity, delay_step_s), options_);
  if (later) reading->per_second = (later->inverse_depth - reading->inverse_depth) / delay_step_s;
  return reading;
}

/// Depth and colour are taken at different times, and stamps often say something else: where a turn moves the depth
/// against the colour tells when it was taken.
void RgbdFollower::State::learn_delay(const SE3& pose) {
  const DelayQuadratic frame = delay_quadratic(measured_, pose);
  delay_information_ += delay_share * frame.information;
  const double change = delay_share * frame.gradient / delay_information_;
  const double delay = std::clamp(depth_delay_s_ + change, -most_delay_s, most_delay_s);
  map_.delay_depths(delay - depth_delay_s_);
  depth_delay_s_ = delay;
}

std::optional<SE3> RgbdFollower::State::pose_from(const std::vector<FoundPoint>& found, const SE3& guess,
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
  const auto pose = estimate_absolute_pose(points, rays, options, guess.inverse());
  result.inliers = pose ? pose->inliers : 0;
  if (!pose || pose->inliers < options_.min_points || 3 * pose->inliers < result.points) return std::nullopt;
  return pose->camera_from_world.inverse();
}

bool RgbdFollower::State::find_pose(const Frame& frame, const SE3& guess, RgbdFollow& result) {
  const std::vector<FoundPoint> carried = tracker_.carry_on(map_, guess);
  const auto first = pose_from(carried, guess, result);
  if (!first) return false;
  found_ = tracker_.recognise(map_, *first, carried);
  measured_ = measurements(frame, found_);
  // Depth readings rest on where the camera was when the depth was taken, which is known now.
  const Vector6d velocity = velocity_to(frame.stamp, *first);
  if (!frame.depth.empty()) {
    for (PointMeasurement& point : measured_) {
      if (const auto reading = read(frame, point.ray, velocity)) {
        point.per_second = reading->per_second;
        point.inverse_depth = reading->inverse_depth;
        point.inverse_depth_sigma = reading->sigma;
      }
    }
  }
  const PoseSolution solution = solve_pose(measured_, *first, solver_iterations);
  result.points = static_cast<int>(measured_.size());
  result.inliers = 0;
  const SE3 camera_from_world = solution.world_from_camera.inverse();
  std::vector<FoundPoint> inliers;
  std::vector<PointMeasurement> inlier_measurements;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    const Eigen::Vector3d p = camera_from_world * measured_[i].in_world;
    if (p.z() > 0.0 && (p.head<2>() / p.z() - measured_[i].ray).norm() * camera_.fx <= options_.max_error_px) {
      inliers.push_back(found_[i]);
      inlier_measurements.push_back(measured_[i]);
    } else {
      map_.points[found_[i].point].tracked = false;
      ++map_.points[found_[i].point].missed;
    }
  }
  found_ = std::move(inliers);
  measured_ = std::move(inlier_measurements);
  result.inliers = static_cast<int>(found_.size());
  if (result.inliers < options_.min_points) return false;
  result.world_from_camera = solution.world_from_camera;
  result.covariance = (solution.points.information + 1e-6 * Matrix6d::Identity()).inverse();
  note_pose(frame.stamp, solution.world_from_camera);
  if (options_.learn_delay) learn_delay(solution.world_from_camera);
  learn_depths(found_, measured_, solution.world_from_camera);
  result.texture_share = 1.0;
  return true;
}

std::vector<PointMeasurement> RgbdFollower::State::measurements(const Frame&,
                                                                const std::vector<FoundPoint>& found) const {
  std::vector<PointMeasurement> measured;
  for (const FoundPoint& here : found) {
    const MapPoint& point = map_.points[here.point];
    PointMeasurement m;
    m.in_world = map_.in_world(point);
    const Eigen::Vector3d along = map_.world_from_anchor(point).rotation() * Eigen::Vector3d(point.ray.homogeneous());
    m.in_world_per_inverse_depth = -along / (point.inverse_depth * point.inverse_depth);
    m.inverse_depth_variance = 1.0 / point.information;
    m.map_per_second = point.per_second;
    m.ray = here.ray;
    m.ray_sigma = options_.pixel_sigma / camera_.fx * (here.recognised ? 1.0 : carried_sigma_factor);
    measured.push_back(m);
  }
  return measured;
}

void RgbdFollower::State::learn_depths(const std::vector<FoundPoint>& found,
                                       const std::vector<PointMeasurement>& measured, const SE3& pose) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    MapPoint& point = map_.points[found[i].point];
    ++point.seen;
    if (!(measured[i].inverse_depth > 0.0)) continue;
    const SE3 anchor_from_camera = map_.world_from_anchor(point).inverse() * pose;
    const Eigen::Vector3d p = anchor_from_camera * Eigen::Vector3d(Eigen::Vector3d(measured[i].ray.homogeneous()) /
                                                                   measured[i].inverse_depth);
    if (p.z() < options_.min_depth_m) continue;
    PointMap::add_reading(point, {1.0 / p.z(), measured[i].inverse_depth_sigma, measured[i].per_second});
    if (options_.window == 0 || point.sightings.empty()) point.inverse_depth = point.read_inverse_depth;
  }
}

bool RgbdFollower::State::is_reference(const SE3& pose, int inliers) const {
  if (inliers < options_.min_reference_share * reference_inliers_) return true;
  const int oldest = std::max(map_.first_live, static_cast<int>(map_.references.size()) - options_.map_references);
  for (std::size_t i = static_cast<std::size_t>(oldest); i < map_.references.size(); ++i) {
    const Reference& reference = map_.references[i];
    const SE3 way = reference.world_from_camera.inverse() * pose;
    const double turn_deg = way.rotation().log().norm() * 180.0 / std::numbers::pi;
    if (turn_deg < options_.max_reference_turn_deg &&
        way.translation().norm() < options_.max_reference_way * reference.median_depth)
      return false;
  }
  return true;
}

void RgbdFollower::State::add_reference(const Frame& frame, const SE3& pose, const std::vector<FoundPoint>& found) {
  const int number = static_cast<int>(map_.references.size());
  map_.references.push_back({frame.stamp, pose, 1.0, {}});
  for (std::size_t i = 0; i < found.size(); ++i) {
    map_.points[found[i].point].sightings.push_back(
        {number, found[i].ray, measured_[i].inverse_depth, measured_[i].inverse_depth_sigma, measured_[i].per_second});
  }
  const int wanted = options_.features - static_cast<int>(found.size());
  std::vector<double> depths;
  int added = 0;
  for (const Eigen::Vector2f& pixel : tracker_.new_corners(frame, found, 2 * wanted)) {
    if (added >= wanted) break;
    const auto ray = camera_.unproject(pixel.cast<double>());
    if (!ray) continue;
    const auto reading = read(frame, *ray, velocity_);
    if (!reading) continue;
    MapPoint point;
    point.anchor = number;
    point.ray = *ray;
    point.inverse_depth = reading->inverse_depth;
    PointMap::add_reading(point, *reading);
    point.patch.keep(tracker_.pyramid(), pixel, options_.patch_px);
    point.pixel = pixel;
    point.tracked = true;
    map_.points.push_back(std::move(point));
    depths.push_back(1.0 / reading->inverse_depth);
    ++added;
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (measured_[i].inverse_depth > 0.0) depths.push_back(1.0 / measured_[i].inverse_depth);
  }
  if (!depths.empty()) {
    std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
    map_.references.back().median_depth = depths[depths.size() / 2];
  }
  reference_inliers_ = static_cast<int>(found.size()) + added;
}

void RgbdFollower::State::restart(const SE3& world_from_camera) {
  map_.first_live = static_cast<int>(map_.references.size());
  map_.points.clear();
  pose_ = world_from_camera;
  velocity_.setZero();
  has_pose_ = false;
}

void RgbdFollower::State::move(const SE3& new_world_from_world) {
  for (Reference& reference : map_.references)
    reference.world_from_camera = new_world_from_world * reference.world_from_camera;
  pose_ = new_world_from_world * pose_;
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
std::vector<SE3> RgbdFollower::reference_poses() const { return state_->reference_poses(); }

}  // namespace rastro
