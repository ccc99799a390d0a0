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
#include "rastro/slam/ekf/joint_compatibility.h"
#include "rastro/slam/ekf/scan_features.h"

namespace rastro {
namespace {

constexpr double degrees = 180.0 / std::numbers::pi;

bool is_finite(const SE2& pose) { return pose.translation().allFinite() && std::isfinite(pose.rotation().angle()); }

int pieces_of(const SE2& step) {
  constexpr double longest_m = 0.2, widest_rad = 0.1, most = 100.0;
  const double pieces = std::max(step.translation().norm() / longest_m, std::abs(step.rotation().angle()) / widest_rad);
  return static_cast<int>(std::ceil(std::clamp(pieces, 1.0, most)));
}

/// The first reason stays: later ones often follow from it.
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

std::size_t bytes_of(const KeyframeScan& scan) {
  return sizeof(KeyframeScan) + scan.points.size() * sizeof(Eigen::Vector2d);
}

bool is_new_keyframe(const std::vector<Keyframe>& keyframes, const SE3& pose, const EkfOptions& options) {
  if (keyframes.empty()) return true;
  const SE3 motion = keyframes.back().world_from_camera.inverse() * pose;
  return motion.translation().norm() >= options.keyframe_m ||
         motion.rotation().log().norm() * degrees >= options.keyframe_deg;
}

}  // namespace

EkfSlam::EkfSlam(const EkfOptions& options, bool scans_expected, const SE2& initial_pose, std::size_t map_budget_bytes)
    : options_(options),
      scans_expected_(scans_expected),
      initial_pose_(initial_pose),
      budget_(map_budget_bytes),
      filter_(initial_pose, {options.translation_scale_error, options.rotation_scale_error}) {}

SlamUpdate EkfSlam::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  update.state = SlamState::tracking;
  observations_.clear();
  if (last_.stamp && frame.stamp <= *last_.stamp) {
    doubt(update, SlamReason::repeated_frame, "timestamp not after the previous one; not used");
    say_pose(update);
    return update;
  }
  predict(frame, update);
  const std::vector<BodyObservation> observations = see(frame, update);
  update.times.push_back({"landmarks", stage.lap_ms()});
  const std::vector<LandmarkAssociation> associations = recognize(frame, observations, update);
  frozen_odometry_.end_frame(associations);
  correct(observations, associations, update);
  judge(associations, update);
  observe(observations, associations);
  learn(observations, associations, update);
  if (place_grew_) recognize_place(update);
  update.times.push_back({"filter", stage.lap_ms()});
  keep(frame, update);
  if (budget_.limited()) stay_within_budget(update);
  update.times.push_back({"map", stage.lap_ms()});
  update.milliseconds = whole.lap_ms();
  return update;
}

void EkfSlam::predict(const Frame& frame, SlamUpdate& update) {
  frozen_odometry_.add(frame);
  if (!last_.stamp) update.reason = SlamReason::first_frame;
  const Motion motion = last_.stamp ? motion_since_last(frame, update) : Motion();
  // In short pieces, so that an error of the heading moves the rest of a long step sideways.
  const int pieces = pieces_of(motion.last_from_body);
  const SE2 piece = SE2::exp(motion.last_from_body.log() / pieces);
  for (int i = 0; i < pieces; ++i) filter_.predict(piece, motion.covariance / pieces);
  blind_m_ += motion.last_from_body.translation().norm();
}

Motion EkfSlam::motion_since_last(const Frame& frame, SlamUpdate& update) {
  const double seconds = static_cast<double>(frame.stamp - *last_.stamp) * 1e-9;
  const bool told = frame.odometry_from_body && is_finite(*frame.odometry_from_body);
  if (frozen_odometry_.frozen()) return Motion();
  if (told && last_.odometry) return motion_by_odometry(*frame.odometry_from_body, seconds, update);
  doubt(update, SlamReason::no_odometry,
        told ? "the previous frame had none; constant motion is assumed" : "constant motion is assumed");
  return carried_motion(last_.motion, last_.seconds, seconds, options_);
}

Motion EkfSlam::motion_by_odometry(const SE2& odometry_from_body, double seconds, SlamUpdate& update) {
  const SE2 last_from_body = last_.odometry->inverse() * odometry_from_body;
  const auto& thaw = frozen_odometry_.thaw();
  const bool jump = is_jump(last_from_body, seconds, options_);
  if (thaw && (jump || thaw->frozen) && !is_jump(last_from_body, thaw->seconds, options_))
    return motion_after_frozen(last_from_body, update);
  if (jump) {
    doubt(update, SlamReason::odometry_jumped,
          fmt::format("{:.3g} m and {:.0f} deg in {:.3g} s; constant motion is assumed",
                      last_from_body.translation().norm(), last_from_body.rotation().angle() * degrees, seconds));
    odometry_check_.interrupt();
    return carried_motion(last_.motion, last_.seconds, seconds, options_);
  }
  last_.motion = last_from_body;
  last_.seconds = seconds;
  return measured_motion(last_from_body, options_);
}

/// Odometry that was frozen: its first step is of the whole time, of which landmarks may have told a part.
Motion EkfSlam::motion_after_frozen(const SE2& last_from_body, SlamUpdate& update) {
  constexpr double sigma_share = 0.1;
  const FrozenOdometry::Thaw& thaw = *frozen_odometry_.thaw();
  doubt(update, SlamReason::odometry_jumped,
        fmt::format("{:.3g} m and {:.0f} deg at once after {:.3g} s in which odometry stayed the same: believed, as no "
                    "landmark tells otherwise",
                    last_from_body.translation().norm(), last_from_body.rotation().angle() * degrees, thaw.seconds));
  odometry_check_.interrupt();
  Motion motion = measured_motion(SE2::exp(thaw.share * last_from_body.log()), options_);
  const double distance = last_from_body.translation().norm(), angle = last_from_body.rotation().angle();
  motion.covariance.diagonal() += (sigma_share * Eigen::Vector3d(distance, distance, angle)).cwiseAbs2();
  return motion;
}

/// Of a body whose odometry is frozen, since a landmark was recognized.
Motion EkfSlam::unknown_motion(double frame_seconds) const {
  const double seconds = frozen_odometry_.unknown_frames() * frame_seconds;
  return carried_motion(SE2(), seconds, seconds, options_);
}

/// The landmarks of the observations, where the body is now. They also tell whether it moved without odometry.
std::vector<LandmarkAssociation> EkfSlam::recognize(const Frame& frame, std::span<const BodyObservation> observations,
                                                    SlamUpdate& update) {
  std::vector<LandmarkAssociation> associations;
  if (!frozen_odometry_.frozen()) {
    associations = associate(filter_, records_, observations, options_);
    frozen_odometry_.judge(associations);
  }
  if (!frozen_odometry_.frozen()) return associations;
  doubt(update, SlamReason::no_odometry, "odometry stays the same to the last bit while the body moves; not used");
  odometry_check_.interrupt();
  if (frozen_odometry_.lost()) {
    associations.assign(observations.size(), {LandmarkAssociation::Kind::unmatched});
  } else if (!observations.empty()) {
    const Motion motion = unknown_motion(static_cast<double>(frame.stamp - last_.stamp.value_or(frame.stamp)) * 1e-9);
    filter_.predict(motion.last_from_body, motion.covariance);
    associations = associate(filter_, records_, observations, options_);
  }
  return associations;
}

std::vector<BodyObservation> EkfSlam::see(const Frame& frame, SlamUpdate& update) const {
  std::vector<BodyObservation> observations = given_observations(frame.landmarks, options_);
  if (!frame.scan) {
    if (scans_expected_ && observations.empty()) doubt(update, SlamReason::no_data, "no scan; odometry alone");
    return observations;
  }
  const int returns = returns_of(*frame.scan);
  if (returns < options_.min_returns) {
    doubt(update, SlamReason::few_returns,
          fmt::format("needs at least {} valid beams, got {} of {}; odometry alone", options_.min_returns, returns,
                      frame.scan->ranges.size()));
    return observations;
  }
  Random random(seed_for(options_.seed, static_cast<std::uint64_t>(frame.index)));
  for (BodyObservation& observation : scan_observations(*frame.scan, options_, random))
    observations.push_back(std::move(observation));
  return observations;
}

void EkfSlam::correct(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations,
                      SlamUpdate& update) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const auto& [kind, landmark, distance] = associations[i];
    if (kind != LandmarkAssociation::Kind::landmark && kind != LandmarkAssociation::Kind::candidate) continue;
    LandmarkRecord& record = records_[landmark];
    ++record.observations;
    record.last_frame = static_cast<std::int64_t>(trajectory_.size());
    record.noise_m2 = observations[i].covariance.trace();
    place_grew_ |= record.observations == options_.observations;
    if (maps_ && record.is_candidate() && record.observations >= options_.observations) confirm(landmark, update);
    if (record.is_candidate()) continue;
    filter_.update(landmark, observations[i].in_body, observations[i].covariance);
    ++update.used;
  }
}

void EkfSlam::confirm(std::size_t landmark, SlamUpdate& update) {
  records_[landmark].id = confirmed_++;
  const Eigen::Vector2d position = filter_.landmark(landmark);
  update.events.push_back(
      {"landmark", fmt::format("{} at ({:.2f}, {:.2f}) m, sigma {:.2g} m", records_[landmark].id, position.x(),
                               position.y(), std::sqrt(filter_.landmark_covariance(landmark).trace()))});
}

void EkfSlam::judge(std::span<const LandmarkAssociation> associations, SlamUpdate& update) {
  if (!associations.empty()) update.score = static_cast<double>(update.used) / static_cast<double>(associations.size());
  if (update.used > 0) blind_m_ = 0.0;
  const auto contradicting = std::count_if(
      associations.begin(), associations.end(),
      [](const LandmarkAssociation& one) { return one.kind == LandmarkAssociation::Kind::contradicting; });
  if (contradicting > 1 && contradicting > update.used) {
    doubt(update, SlamReason::poor_match,
          fmt::format("{} of {} observations contradict the map", contradicting, associations.size()));
  } else if (blind_m_ > options_.max_blind_m) {
    doubt(update, SlamReason::too_few_points, fmt::format("no landmark observed over {:.1f} m", blind_m_));
  }
}

void EkfSlam::learn(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations,
                    SlamUpdate& update) {
  const auto frame = static_cast<std::int64_t>(trajectory_.size());
  const double heading = filter_.world_from_body().rotation().angle();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (associations[i].kind != LandmarkAssociation::Kind::fresh || !has_room()) continue;
    const BodyObservation& seen = observations[i];
    filter_.add(seen.in_body, seen.covariance);
    records_.push_back({-1, seen.kind, seen.sensor_id, seen.direction + heading, 1, frame, seen.covariance.trace()});
    if (options_.observations > 1 || !maps_) continue;
    confirm(records_.size() - 1, update);
    observations_[i].landmark = records_.back().id;
    observations_[i].state = ObservationState::new_landmark;
  }
  forget_candidates();
}

/// After a long way: landmarks that were mapped anew are those of before.
void EkfSlam::recognize_place(SlamUpdate& update) {
  place_grew_ = false;
  std::vector<LandmarkPair> pairs = recognized_pairs(filter_, records_, options_);
  if (pairs.empty()) return;
  const SE2 before = filter_.world_from_body();
  const double noise = options_.corner_error_m * options_.corner_error_m;
  for (const LandmarkPair& pair : pairs) {
    filter_.unite(pair.recent, pair.known, noise * Eigen::Matrix2d::Identity());
    records_[pair.known].observations += records_[pair.recent].observations;
    records_[pair.known].last_frame = records_[pair.recent].last_frame;
    records_[pair.known].noise_m2 = records_[pair.recent].noise_m2;
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const LandmarkPair& a, const LandmarkPair& b) { return a.recent > b.recent; });
  for (const LandmarkPair& pair : pairs) remove_landmark(pair.recent);
  const SE2 moved = before.inverse() * filter_.world_from_body();
  update.events.push_back(
      {"loop_closed",
       fmt::format("{} landmarks recognized together; the pose moves by {:.2f} m and {:.1f} deg", pairs.size(),
                   moved.translation().norm(), std::abs(moved.rotation().angle()) * degrees)});
}

/// The last one takes its number.
void EkfSlam::remove_landmark(std::size_t landmark) {
  filter_.remove(landmark);
  records_[landmark] = records_.back();
  records_.pop_back();
}

bool EkfSlam::has_room() const {
  return records_.size() < static_cast<std::size_t>(options_.max_landmarks) &&
         (!budget_.limited() || landmark_bytes() < budget_.full_bytes());
}

/// Call it before forget_candidates(), which renumbers the records.
void EkfSlam::observe(std::span<const BodyObservation> observations,
                      std::span<const LandmarkAssociation> associations) {
  using Kind = LandmarkAssociation::Kind;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const auto& [kind, landmark, distance] = associations[i];
    FeatureObservation seen;
    seen.in_body = observations[i].in_body;
    if (kind != Kind::fresh && kind != Kind::unmatched) seen.landmark = records_[landmark].id;
    if (kind == Kind::landmark) seen.state = ObservationState::inlier;
    if (kind == Kind::contradicting) seen.state = ObservationState::outlier;
    if (kind == Kind::ambiguous) seen.state = ObservationState::matched;
    if (kind == Kind::candidate)
      seen.state = seen.landmark >= 0 ? ObservationState::new_landmark : ObservationState::matched;
    observations_.push_back(seen);
  }
}

void EkfSlam::forget_candidates() {
  const auto frame = static_cast<std::int64_t>(trajectory_.size());
  // From the back: the last landmark, which takes the number of a removed one, was checked before.
  for (std::size_t i = records_.size(); i-- > 0;) {
    if (!records_[i].is_candidate() || frame - records_[i].last_frame <= options_.candidate_frames) continue;
    remove_landmark(i);
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
  if (frame.scan && options_.grid && maps_) keep_scan(*frame.scan, world_from_body);
  const bool told = frame.odometry_from_body && is_finite(*frame.odometry_from_body);
  last_.odometry = told ? frame.odometry_from_body : std::nullopt;
  if (told) {
    odometry_check_.add(*frame.odometry_from_body, world_from_body, update.used > 0);
  } else {
    odometry_check_.interrupt();
  }
  last_.stamp = frame.stamp;
}

void EkfSlam::add_keyframe(const Frame& frame, const SE3& world_from_body) {
  const auto id = static_cast<KeyframeId>(keyframes_.size());
  keyframes_.push_back({id, frame.index, frame.stamp, 0, world_from_body, 0, id - 1, 1.0});
  scans_.emplace_back();
}

void EkfSlam::keep_scan(const LaserScan& scan, const SE2& world_from_body) {
  const std::size_t every = std::size_t{1} << static_cast<unsigned>(budget_.stage());
  if (scans_seen_++ % every != 0) return;
  const SE2 keyframe_from_body = in_plane(keyframes_.back().world_from_camera).inverse() * world_from_body;
  const SE2 keyframe_from_laser = keyframe_from_body * scan.body_from_laser;
  scans_.back().push_back({keyframe_from_laser.translation(), returns_in(scan, keyframe_from_laser)});
  scan_bytes_ += bytes_of(scans_.back().back());
}

void EkfSlam::stay_within_budget(SlamUpdate& update) {
  if (budget_.note(map_bytes()))
    update.events.push_back(
        budget_.event(map_bytes(), fmt::format("one scan in {} is kept for the grid", 1 << budget_.stage())));
  while (map_bytes() > budget_.full_bytes() && thin_scans())
    update.events.push_back(budget_.event(map_bytes(), "every second kept scan was dropped"));
}

/// Consecutive scans are nearly the same.
bool EkfSlam::thin_scans() {
  std::size_t number = 0, given_up = 0;
  for (KeyframeScans& scans : scans_) {
    std::erase_if(scans, [&](const KeyframeScan& scan) {
      if (number++ % 2 == 0) return false;
      scan_bytes_ -= bytes_of(scan);
      ++given_up;
      return true;
    });
  }
  return given_up > 0;
}

/// One joint covariance of the body and all landmarks.
std::size_t EkfSlam::landmark_bytes() const {
  const std::size_t size = 5 + 2 * records_.size();
  return sizeof(double) * size * size + sizeof(LandmarkRecord) * records_.size();
}

std::size_t EkfSlam::map_bytes() const {
  return landmark_bytes() + scan_bytes_ + trajectory_.size() * (sizeof(StampedPose) + sizeof(KeyframeId)) +
         keyframes_.size() * (sizeof(Keyframe) + sizeof(KeyframeScans));
}

MapMemory EkfSlam::map_memory() const {
  MapMemory memory{map_bytes(), budget_.bytes(), ""};
  if (budget_.stage() > 0) memory.measures = fmt::format("one scan in {} kept for the grid", 1 << budget_.stage());
  return memory;
}

void EkfSlam::say_pose(SlamUpdate& update) const {
  update.world_from_body = in_space(filter_.world_from_body());
  Eigen::Matrix3d covariance = filter_.body_covariance();
  if (frozen_odometry_.lost()) covariance += unknown_motion(last_.seconds).covariance;
  update.covariance = in_space(covariance);
}

std::vector<SlamEvent> EkfSlam::finish() {
  std::vector<SlamEvent> events;
  if (records_.size() >= static_cast<std::size_t>(options_.max_landmarks)) {
    events.push_back({"landmark", fmt::format("the map is full: max_landmarks={}", options_.max_landmarks)});
  }
  const OdometryCheck::Result result = odometry_check_.result();
  if (result.meters > 0 || result.rotations > 0) events.push_back({"odometry", describe(result)});
  return events;
}

void EkfSlam::reset() { *this = EkfSlam(options_, scans_expected_, initial_pose_, budget_.bytes()); }

/// Known landmarks are still updated: a filter cannot localize otherwise.
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
    constexpr double least_variance = 1e-8;  // a robot that only rotated knows its position, but not with infinite
                                             // precision
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
  map->sessions.push_back({0, 0, "", first, last_.stamp.value_or(0), {true, 0.0, "wheel odometry and laser"}});
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
