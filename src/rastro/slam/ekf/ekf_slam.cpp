// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/ekf_slam.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "rastro/base/random.h"
#include "rastro/base/stopwatch.h"
#include "rastro/map/graph/planar.h"
#include "rastro/slam/ekf/scan_features.h"

namespace rastro {
namespace {

constexpr double degrees = 180.0 / std::numbers::pi;

bool is_finite(const SE2& pose) { return pose.translation().allFinite() && std::isfinite(pose.rotation().angle()); }

/// The first reason stands: what comes later often follows from it.
void doubt(SlamUpdate& update, SlamReason reason, std::string detail) {
  update.state = SlamState::weak;
  if (update.reason != SlamReason::none && update.reason != SlamReason::first_frame) return;
  update.reason = reason;
  update.detail = std::move(detail);
}

int returns_of(const LaserScan& scan) {
  int count = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) count += scan.is_return(beam) ? 1 : 0;
  return count;
}

bool is_new_keyframe(const std::vector<Keyframe>& keyframes, const SE3& pose, const EkfOptions& options) {
  if (keyframes.empty()) return true;
  const SE3 motion = keyframes.back().world_from_camera.inverse() * pose;
  return motion.translation().norm() >= options.keyframe_m ||
         motion.rotation().log().norm() * degrees >= options.keyframe_deg;
}

}  // namespace

EkfSlam::EkfSlam(const EkfOptions& options, bool scans_expected) : options_(options), scans_expected_(scans_expected) {}

SlamUpdate EkfSlam::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  update.state = SlamState::tracking;
  if (last_stamp_ && frame.stamp <= *last_stamp_) {
    doubt(update, SlamReason::repeated_frame, "its time does not go on; not used");
    say_pose(update);
    return update;
  }
  predict(frame, update);
  const std::vector<BodySighting> sightings = see(frame, update);
  update.times.push_back({"landmarks", stage.lap_ms()});
  const std::vector<LandmarkAssociation> associations = associate(filter_, records_, sightings, options_);
  correct(sightings, associations, update);
  judge(associations, update);
  if (maps_) learn(sightings, associations, update);
  update.times.push_back({"filter", stage.lap_ms()});
  keep(frame, update);
  update.times.push_back({"map", stage.lap_ms()});
  update.milliseconds = whole.lap_ms();
  return update;
}

void EkfSlam::predict(const Frame& frame, SlamUpdate& update) {
  if (!last_stamp_) update.reason = SlamReason::first_frame;
  const Motion motion = last_stamp_ ? motion_since_last(frame, update) : Motion();
  filter_.predict(motion.last_from_body, motion.covariance);
  blind_m_ += motion.last_from_body.translation().norm();
}

Motion EkfSlam::motion_since_last(const Frame& frame, SlamUpdate& update) {
  const double seconds = static_cast<double>(frame.stamp - *last_stamp_) * 1e-9;
  const bool told = frame.odometry_from_body && is_finite(*frame.odometry_from_body);
  if (told && last_odometry_) return motion_by_odometry(*frame.odometry_from_body, seconds, update);
  doubt(update, SlamReason::no_odometry,
        told ? "the frame before had none; the last motion is carried on" : "the last motion is carried on");
  return carried_motion(last_motion_, last_seconds_, seconds, options_);
}

Motion EkfSlam::motion_by_odometry(const SE2& odometry_from_body, double seconds, SlamUpdate& update) {
  const SE2 last_from_body = last_odometry_->inverse() * odometry_from_body;
  if (is_jump(last_from_body, seconds, options_)) {
    doubt(update, SlamReason::odometry_jumped,
          fmt::format("{:.3g} m and {:.0f} deg in {:.3g} s; the last motion is carried on",
                      last_from_body.translation().norm(), last_from_body.rotation().angle() * degrees, seconds));
    odometry_check_.interrupt();
    return carried_motion(last_motion_, last_seconds_, seconds, options_);
  }
  last_motion_ = last_from_body;
  last_seconds_ = seconds;
  return measured_motion(last_from_body, options_);
}

std::vector<BodySighting> EkfSlam::see(const Frame& frame, SlamUpdate& update) const {
  std::vector<BodySighting> sightings = given_sightings(frame.landmarks, options_);
  if (!frame.scan) {
    if (scans_expected_ && sightings.empty()) doubt(update, SlamReason::no_data, "no scan; odometry alone");
    return sightings;
  }
  const int returns = returns_of(*frame.scan);
  if (returns < options_.min_returns) {
    doubt(update, SlamReason::few_returns,
          fmt::format("{} of {} beams returned, need {}; odometry alone", returns, frame.scan->ranges.size(),
                      options_.min_returns));
    return sightings;
  }
  Random random(seed_for(options_.seed, static_cast<std::uint64_t>(frame.index)));
  for (BodySighting& sighting : scan_sightings(*frame.scan, options_, random)) sightings.push_back(std::move(sighting));
  return sightings;
}

void EkfSlam::correct(std::span<const BodySighting> sightings, std::span<const LandmarkAssociation> associations,
                      SlamUpdate& update) {
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const auto& [kind, landmark, distance] = associations[i];
    if (kind != LandmarkAssociation::Kind::landmark && kind != LandmarkAssociation::Kind::candidate) continue;
    LandmarkRecord& record = records_[landmark];
    ++record.observations;
    record.last_frame = static_cast<std::int64_t>(trajectory_.size());
    if (record.is_candidate() && record.observations >= options_.observations) confirm(landmark, update);
    if (record.is_candidate()) continue;
    filter_.update(landmark, sightings[i].in_body, sightings[i].covariance);
    ++update.used;
  }
}

void EkfSlam::confirm(std::size_t landmark, SlamUpdate& update) {
  records_[landmark].id = confirmed_++;
  const Eigen::Vector2d place = filter_.landmark(landmark);
  update.events.push_back(
      {"landmark", fmt::format("{} at ({:.2f}, {:.2f}) m, known to {:.2g} m", records_[landmark].id, place.x(),
                               place.y(), std::sqrt(filter_.landmark_covariance(landmark).trace()))});
}

void EkfSlam::judge(std::span<const LandmarkAssociation> associations, SlamUpdate& update) {
  if (!associations.empty()) update.score = static_cast<double>(update.used) / static_cast<double>(associations.size());
  if (update.used > 0) blind_m_ = 0.0;
  const auto contradicting = std::count_if(
      associations.begin(), associations.end(),
      [](const LandmarkAssociation& one) { return one.kind == LandmarkAssociation::Kind::contradicting; });
  if (contradicting > 1 && contradicting > update.used) {
    doubt(update, SlamReason::poor_match,
          fmt::format("{} of {} sightings contradict the map", contradicting, associations.size()));
  } else if (blind_m_ > options_.max_blind_m) {
    doubt(update, SlamReason::too_few_points, fmt::format("no landmark recognised over {:.1f} m", blind_m_));
  }
}

void EkfSlam::learn(std::span<const BodySighting> sightings, std::span<const LandmarkAssociation> associations,
                    SlamUpdate& update) {
  const auto frame = static_cast<std::int64_t>(trajectory_.size());
  const double heading = filter_.world_from_body().rotation().angle();
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const bool room = records_.size() < static_cast<std::size_t>(options_.max_landmarks);
    if (associations[i].kind != LandmarkAssociation::Kind::fresh || !room) continue;
    const BodySighting& seen = sightings[i];
    filter_.add(seen.in_body, seen.covariance);
    records_.push_back({-1, seen.kind, seen.sensor_id, seen.direction + heading, 1, frame});
    if (options_.observations <= 1) confirm(records_.size() - 1, update);
  }
  forget_candidates();
}

void EkfSlam::forget_candidates() {
  const auto frame = static_cast<std::int64_t>(trajectory_.size());
  // From the back: the last landmark, which takes a forgotten one's number, has been looked at then.
  for (std::size_t i = records_.size(); i-- > 0;) {
    if (!records_[i].is_candidate() || frame - records_[i].last_frame <= options_.candidate_frames) continue;
    filter_.remove(i);
    records_[i] = records_.back();
    records_.pop_back();
  }
}

void EkfSlam::keep(const Frame& frame, SlamUpdate& update) {
  say_pose(update);
  const SE2 world_from_body = filter_.world_from_body();
  trajectory_.push_back({frame.stamp, update.world_from_body});
  const bool needs_keyframe = keyframes_.empty() || maps_;
  if (needs_keyframe && is_new_keyframe(keyframes_, update.world_from_body, options_))
    add_keyframe(frame, update.world_from_body);
  keyframe_of_frame_.push_back(keyframes_.back().id);
  if (frame.scan && options_.grid && maps_) {
    const SE2 keyframe_from_body = in_plane(keyframes_.back().world_from_camera).inverse() * world_from_body;
    const SE2 keyframe_from_laser = keyframe_from_body * frame.scan->body_from_laser;
    scans_.back().push_back({keyframe_from_laser.translation(), returns_in(*frame.scan, keyframe_from_laser)});
  }
  const bool told = frame.odometry_from_body && is_finite(*frame.odometry_from_body);
  last_odometry_ = told ? frame.odometry_from_body : std::nullopt;
  if (told) {
    odometry_check_.add(*frame.odometry_from_body, world_from_body, update.used > 0);
  } else {
    odometry_check_.interrupt();
  }
  last_stamp_ = frame.stamp;
}

void EkfSlam::add_keyframe(const Frame& frame, const SE3& world_from_body) {
  const auto id = static_cast<KeyframeId>(keyframes_.size());
  keyframes_.push_back({id, frame.index, frame.stamp, 0, world_from_body, 0, id - 1, 1.0});
  scans_.emplace_back();
}

void EkfSlam::say_pose(SlamUpdate& update) const {
  update.world_from_body = in_space(filter_.world_from_body());
  update.covariance = in_space(filter_.body_covariance());
}

std::vector<SlamEvent> EkfSlam::finish() {
  std::vector<SlamEvent> events;
  if (records_.size() >= static_cast<std::size_t>(options_.max_landmarks)) {
    events.push_back({"landmark", fmt::format("the map is full with max_landmarks={}", options_.max_landmarks)});
  }
  const OdometryCheck::Result result = odometry_check_.result();
  if (result.metres > 0 || result.turns > 0) events.push_back({"odometry", describe(result)});
  return events;
}

void EkfSlam::reset() { *this = EkfSlam(options_, scans_expected_); }

/// Landmarks known go on to be updated: a filter has no other way to localize.
bool EkfSlam::set_mapping(bool on) {
  maps_ = on;
  return true;
}

std::shared_ptr<const LandmarkLayer> EkfSlam::landmarks() const {
  auto layer = std::make_shared<LandmarkLayer>();
  std::vector<std::size_t> confirmed;
  for (std::size_t i = 0; i < records_.size(); ++i)
    if (!records_[i].is_candidate()) confirmed.push_back(i);
  std::sort(confirmed.begin(), confirmed.end(),
            [this](std::size_t a, std::size_t b) { return records_[a].id < records_[b].id; });
  for (const std::size_t i : confirmed) {
    Landmark& landmark = layer->landmarks.emplace_back();
    landmark.id = records_[i].id;
    landmark.position.head<2>() = filter_.landmark(i);
    LandmarkEstimate& estimate = layer->estimates.emplace_back();
    estimate.sensor_id = records_[i].sensor_id;
    estimate.observations = records_[i].observations;
    estimate.covariance.setZero();
    estimate.covariance.topLeftCorner<2, 2>() = filter_.landmark_covariance(i);
  }
  return layer;
}

std::shared_ptr<const Map> EkfSlam::snapshot() const {
  auto map = std::make_shared<Map>();
  map->method = "ekf";
  map->revision = static_cast<std::int64_t>(trajectory_.size());
  map->keyframes = keyframes_;
  for (std::size_t i = 1; i < keyframes_.size(); ++i) {
    const SE2 motion = in_plane(keyframes_[i - 1].world_from_camera.inverse() * keyframes_[i].world_from_camera);
    constexpr double least_variance = 1e-8;  // a robot that only turned knows where it is, but not without end
    Eigen::Matrix3d covariance = measured_motion(motion, options_).covariance;
    covariance.diagonal().array() += least_variance;
    map->constraints.push_back(planar_constraint(keyframes_[i - 1].id, keyframes_[i].id, motion, covariance.inverse(),
                                                 ConstraintKind::odometry));
  }
  for (std::size_t i = 0; i < trajectory_.size(); ++i) {
    const Keyframe& keyframe = keyframes_[static_cast<std::size_t>(keyframe_of_frame_[i])];
    map->frames.push_back(
        {trajectory_[i].stamp, keyframe.id, keyframe.world_from_camera.inverse() * trajectory_[i].world_from_body});
  }
  const TimeNs first = trajectory_.empty() ? 0 : trajectory_.front().stamp;
  map->sessions.push_back({0, 0, "", first, last_stamp_.value_or(0), {true, 0.0, "wheel odometry and laser"}});
  map->layers.put<LandmarkLayer>(landmarks());
  if (!options_.grid || !scans_expected_) return map;
  auto scans = std::make_shared<ScanLayer>();
  scans->cell_m = options_.cell_m;
  for (std::size_t i = 0; i < scans_.size(); ++i)
    if (!scans_[i].empty()) scans->of[keyframes_[i].id] = std::make_shared<KeyframeScans>(scans_[i]);
  if (!scans->of.empty()) map->layers.put<ScanLayer>(std::move(scans));
  return map;
}

}  // namespace rastro
