// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/ekf_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "rastro/base/random.h"
#include "rastro/base/stopwatch.h"
#include "rastro/map/graph/planar.h"
#include "rastro/slam/ekf/joint_compatibility.h"
#include "rastro/slam/ekf/landmark_estimates.h"
#include "rastro/slam/ekf/mark_weak.h"
#include "rastro/slam/ekf/scan_features.h"

namespace rastro {
namespace {

constexpr double degrees = 180.0 / std::numbers::pi;

int pieces_of(const SE2& step) {
  constexpr double longest_m = 0.2, widest_rad = 0.1, most = 100.0;
  const double pieces = std::max(step.translation().norm() / longest_m, std::abs(step.rotation().angle()) / widest_rad);
  return static_cast<int>(std::ceil(std::clamp(pieces, 1.0, most)));
}

int returns_of(const LaserScan& scan) {
  int count = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) count += scan.is_return(beam) ? 1 : 0;
  return count;
}

}  // namespace

EkfSlam::EkfSlam(const EkfOptions& options, bool scans_expected, const SE2& initial_pose, std::size_t map_budget_bytes)
    : options_(options),
      scans_expected_(scans_expected),
      initial_pose_(initial_pose),
      budget_(map_budget_bytes),
      room_(options, budget_.full_bytes()),
      filter_(initial_pose, {options.translation_scale_error, options.rotation_scale_error}),
      motion_(options),
      keyframes_(options, options.grid && scans_expected) {
  filter_.expect_at_most(room_.most());
}

SlamUpdate EkfSlam::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  update.state = SlamState::tracking;
  observations_.clear();
  if (!is_in_time(frame, update)) {
    say_pose(update);
    return update;
  }
  predict(frame, update);
  const std::vector<BodyObservation> observations = see(frame, update);
  update.times.push_back({"landmarks", stage.lap_ms()});
  const std::vector<LandmarkAssociation> associations = recognize(observations, update);
  correct(observations, associations, update);
  judge(associations, update);
  observe(observations, associations);
  learn(observations, associations, update);
  if (place_grew_) recognize_place(update);
  check_consistency(update);
  update.times.push_back({"filter", stage.lap_ms()});
  keep(frame, associations, update);
  if (budget_.limited()) stay_within_budget(update);
  update.times.push_back({"map", stage.lap_ms()});
  update.milliseconds = whole.lap_ms();
  return update;
}

bool EkfSlam::is_in_time(const Frame& frame, SlamUpdate& update) {
  const StampCheck::Result result = stamps_.check(frame.stamp);
  if (result == StampCheck::Result::repeated) {
    mark_weak(update, SlamReason::repeated_frame, "timestamp not after the previous one; not used");
  } else if (result == StampCheck::Result::ahead) {
    mark_weak(update, SlamReason::gap,
              fmt::format("timestamp {:.3g} s after the previous one; not used before the next frame confirms it",
                          to_seconds(frame.stamp - keyframes_.trajectory().back().stamp)));
  } else if (result == StampCheck::Result::first_wrong) {
    keyframes_.begin_at(stamps_.first());
    motion_.begin_at(stamps_.first());
  }
  return result == StampCheck::Result::fits || result == StampCheck::Result::first_wrong;
}

void EkfSlam::predict(const Frame& frame, SlamUpdate& update) {
  if (keyframes_.frames() == 0) update.reason = SlamReason::first_frame;
  const Motion motion = motion_.since_last(frame, update);
  if (motion.measured) {
    consistency_.move({filter_.scaled(motion.last_from_body), motion.covariance, true});
  } else {
    consistency_.interrupt();
  }
  // In short pieces, so that an error of the heading moves the rest of a long step sideways.
  const int pieces = pieces_of(motion.last_from_body);
  const SE2 piece = SE2::exp(motion.last_from_body.log() / pieces);
  for (int i = 0; i < pieces; ++i) filter_.predict(piece, motion.covariance / pieces);
  blind_m_ += motion.last_from_body.translation().norm();
}

/// The landmarks of the observations, where the body is now. They also tell whether it moved without odometry.
std::vector<LandmarkAssociation> EkfSlam::recognize(std::span<const BodyObservation> observations, SlamUpdate& update) {
  std::vector<LandmarkAssociation> associations;
  if (!motion_.frozen()) associations = associate(filter_, records_, observations, options_);
  if (!motion_.is_frozen(associations, update)) return associations;
  if (motion_.lost()) {
    associations.assign(observations.size(), {LandmarkAssociation::Kind::unmatched});
  } else if (!observations.empty()) {
    const Motion motion = motion_.unknown();
    filter_.predict(motion.last_from_body, motion.covariance);
    associations = associate(filter_, records_, observations, options_);
  }
  return associations;
}

std::vector<BodyObservation> EkfSlam::see(const Frame& frame, SlamUpdate& update) const {
  std::vector<BodyObservation> observations = given_observations(frame.landmarks, options_);
  if (!frame.scan) {
    if (scans_expected_ && observations.empty()) mark_weak(update, SlamReason::no_data, "no scan; odometry alone");
    return observations;
  }
  const int returns = returns_of(*frame.scan);
  if (returns < options_.min_returns) {
    mark_weak(update, SlamReason::few_returns,
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
    record.last_frame = frame_number();
    place_grew_ |= record.observations == options_.observations;
    if (record.is_candidate() && record.observations >= options_.observations && may_confirm())
      confirm(landmark, update);
    if (record.is_candidate()) continue;
    record.noise_m2 = std::min(record.noise_m2, observations[i].covariance.trace());
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
    mark_weak(update, SlamReason::poor_match,
              fmt::format("{} of {} observations contradict the map", contradicting, associations.size()));
  } else if (blind_m_ > options_.max_blind_m) {
    mark_weak(update, SlamReason::too_few_points, fmt::format("no landmark observed over {:.1f} m", blind_m_));
  }
}

void EkfSlam::learn(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations,
                    SlamUpdate& update) {
  const double heading = filter_.world_from_body().rotation().angle();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (associations[i].kind != LandmarkAssociation::Kind::fresh || records_.size() >= room_.most()) continue;
    const BodyObservation& seen = observations[i];
    filter_.add(seen.in_body, seen.covariance);
    records_.push_back(
        {-1, seen.kind, seen.sensor_id, seen.direction + heading, 1, frame_number(), seen.covariance.trace()});
    if (options_.observations > 1) continue;
    place_grew_ = true;
    if (!may_confirm()) continue;
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
  std::vector<std::size_t> around;  // They turn with the body.
  for (std::size_t i = 0; i < records_.size(); ++i)
    if (!is_unsure(filter_.expected(i), records_[i].noise_m2, options_)) around.push_back(i);
  for (const LandmarkPair& pair : pairs) unite(pair);
  const SE2 moved = before.inverse() * filter_.world_from_body();
  for (const std::size_t i : around) records_[i].direction += moved.rotation().angle();
  std::sort(pairs.begin(), pairs.end(),
            [](const LandmarkPair& a, const LandmarkPair& b) { return a.recent > b.recent; });
  for (const LandmarkPair& pair : pairs) remove_landmark(pair.recent);
  update.events.push_back(
      {"loop_closed",
       fmt::format("{} landmarks recognized together; the pose moves by {:.2f} m and {:.1f} deg", pairs.size(),
                   moved.translation().norm(), std::abs(moved.rotation().angle()) * degrees)});
}

void EkfSlam::unite(const LandmarkPair& pair) {
  const double noise = options_.corner_error_m * options_.corner_error_m;
  filter_.unite(pair.recent, pair.known, noise * Eigen::Matrix2d::Identity());
  const LandmarkRecord& recent = records_[pair.recent];
  LandmarkRecord& known = records_[pair.known];
  known.observations += recent.observations;
  known.last_frame = recent.last_frame;
  known.noise_m2 = std::min(known.noise_m2, recent.noise_m2);
  for (FeatureObservation& seen : observations_)
    if (seen.landmark >= 0 && seen.landmark == recent.id) seen.landmark = known.id;
}

/// A filter that was once moved against odometry by more than its model explains has a wrong pose and a wrong map.
void EkfSlam::check_consistency(SlamUpdate& update) {
  consistency_.end_frame(filter_.world_from_body(), update.used > 0);
  if (consistency_.factor() > 1.0)
    mark_weak(update, SlamReason::poor_match,
              fmt::format("landmarks and odometry contradict each other: by {:.1f} times what the settings explain",
                          consistency_.factor()));
}

/// The last one takes its number.
void EkfSlam::remove_landmark(std::size_t landmark) {
  filter_.remove(landmark);
  records_[landmark] = records_.back();
  records_.pop_back();
}

/// A candidate beyond the limit stays one.
bool EkfSlam::may_confirm() const { return maps_ && !is_full(); }

bool EkfSlam::is_full() const {
  const auto landmarks = std::count_if(records_.begin(), records_.end(),
                                       [](const LandmarkRecord& record) { return !record.is_candidate(); });
  return static_cast<std::size_t>(landmarks) >= room_.most_confirmed();
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
  // From the back: the last landmark, which takes the number of a removed one, was checked before.
  for (std::size_t i = records_.size(); i-- > 0;) {
    if (!records_[i].is_candidate() || frame_number() - records_[i].last_frame <= options_.candidate_frames) continue;
    remove_landmark(i);
  }
}

void EkfSlam::keep(const Frame& frame, std::span<const LandmarkAssociation> associations, SlamUpdate& update) {
  const SE2 world_from_body = filter_.world_from_body();
  motion_.end_frame(frame, associations, world_from_body, update.used > 0);
  say_pose(update);
  keyframes_.add(frame, world_from_body, maps_, std::size_t{1} << static_cast<unsigned>(budget_.stage()));
}

void EkfSlam::stay_within_budget(SlamUpdate& update) {
  if (budget_.note(map_bytes()))
    update.events.push_back(
        budget_.event(map_bytes(), fmt::format("one scan in {} is kept for the grid", 1 << budget_.stage())));
  while (map_bytes() > budget_.full_bytes() && keyframes_.thin_scans())
    update.events.push_back(budget_.event(map_bytes(), "every second kept scan was dropped"));
}

std::size_t EkfSlam::map_bytes() const {
  return filter_.bytes() + records_.capacity() * sizeof(LandmarkRecord) + keyframes_.bytes();
}

MapMemory EkfSlam::map_memory() const {
  MapMemory memory{map_bytes(), budget_.bytes(), ""};
  if (budget_.stage() > 0) memory.measures = fmt::format("one scan in {} kept for the grid", 1 << budget_.stage());
  return memory;
}

void EkfSlam::say_pose(SlamUpdate& update) const {
  update.world_from_body = in_space(filter_.world_from_body());
  const double factor = consistency_.factor();
  const Eigen::Matrix3d covariance = filter_.body_covariance() + motion_.unknown_covariance();
  update.covariance = in_space(factor * factor * covariance);
}

std::vector<SlamEvent> EkfSlam::finish() {
  std::vector<SlamEvent> events;
  if (is_full()) {
    events.push_back({"landmark", room_.limited_by_memory()
                                      ? fmt::format("the map is full: its memory has room for {}", room_.most())
                                      : fmt::format("the map is full: max_landmarks={}", options_.max_landmarks)});
  }
  const OdometryCheck::Result result = motion_.odometry_error();
  if (result.meters > 0 || result.rotations > 0) events.push_back({"odometry", describe(result)});
  return events;
}

void EkfSlam::reset() { *this = EkfSlam(options_, scans_expected_, initial_pose_, budget_.bytes()); }

/// Known landmarks are still updated: a filter cannot localize otherwise.
bool EkfSlam::set_mapping(bool on) {
  maps_ = on;
  return true;
}

std::shared_ptr<const Map> EkfSlam::snapshot() const {
  auto map = std::make_shared<Map>();
  map->method = "ekf";
  map->revision = frame_number();
  map->layers.put<LandmarkLayer>(landmark_estimates(filter_, records_));
  keyframes_.put_into(*map);
  return map;
}

}  // namespace rastro
