// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/hector_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/checked_options.h"
#include "rastro/base/stopwatch.h"
#include "rastro/map/graph/planar.h"
#include "rastro/slam/hector/final_map.h"
#include "rastro/slam/hector/motion_guess.h"
#include "rastro/slam/hector/pose_uncertainty.h"
#include "rastro/slam/hector/scan_follower.h"
#include "rastro/slam/hector/scan_gap.h"
#include "rastro/slam/hector/submap_graph.h"
#include "rastro/slam/map_budget.h"

namespace rastro {

class HectorSlam::State {
 public:
  State(const HectorOptions& options, TaskPool* pool, std::size_t map_budget_bytes)
      : options_(checked(options, "hector options")),
        follower_(options_),
        guess_(options_),
        graph_(options_, pool),
        uncertainty_(options_, graph_),
        budget_(map_budget_bytes) {}

  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory() const { return scan_trajectory(scans_, graph_); }
  std::shared_ptr<const Map> snapshot() const { return map_of_scans(scans_, graph_, options_, revision_); }
  void set_mapping(bool on) { maps_ = on; }
  MapMemory map_memory() const;

 private:
  void start(const Frame& frame, const ScanPoints& scan, SlamUpdate& update);
  void follow(const Frame& frame, const ScanPoints& scan, SlamUpdate& update);
  void carry_on(const Frame& frame, SlamUpdate& update, SlamReason reason, std::string detail);
  std::optional<ScanGap> account_for_motion(const Frame& frame, const ScanGuess& guess, FollowedScan& followed);
  void judge(const FollowedScan& followed, SlamUpdate& update);
  void judge_fitting(const FollowedScan& followed, SlamUpdate& update) const;
  void report(const ScanGap& gap, SlamUpdate& update);
  void settle(const Frame& frame, const FollowedScan& followed, SlamUpdate& update);
  double distance_to(const SE2& local_from_body) const;
  void extend_map(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed, SlamUpdate& update);
  void begin_submap_after_gap(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed,
                              SlamUpdate& update);
  KeyScan key_scan_of(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed) const;
  bool moved_enough() const;
  Submap* open_submap();
  void advance_submaps(const FollowedScan& followed, SlamUpdate& update);
  void close_loops(SlamUpdate& update);
  std::size_t map_bytes() const { return graph_.bytes() + scans_.size() * sizeof(PosedScan); }
  std::string measures() const;
  void stay_within_budget(SlamUpdate& update);

  HectorOptions options_;
  ScanFollower follower_;
  MotionGuess guess_;
  SubmapGraph graph_;
  PoseUncertainty uncertainty_;
  MapBudget budget_;
  std::string given_up_;  ///< The last measure to save memory; reported when it changes.
  std::vector<PosedScan> scans_;
  std::size_t first_after_gap_ = 0;  ///< Key scan that followed the last missing scans.
  std::size_t searched_up_to_ = 0;   ///< Loop closures of key scans before this one were searched for in older submaps.
  double path_m_ = 0.0;
  std::int64_t revision_ = 0;
  bool lost_ = false;
  bool maps_ = true;  ///< False: scans are only localized.
};

SlamUpdate HectorSlam::State::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  const ScanPoints scan = frame.scan ? returns_of(*frame.scan, options_) : ScanPoints{};
  update.used = static_cast<int>(scan.points.size());
  update.times.push_back({"scan", stage.lap_ms()});
  if (!scans_.empty() && frame.stamp == scans_.back().stamp) {
    update.state = SlamState::weak;
    update.reason = SlamReason::repeated_frame;
    update.detail = "same timestamp as the previous scan";
    update.world_from_body = in_space(graph_.world_from_local() * guess_.last());
  } else if (!frame.scan) {
    carry_on(frame, update, SlamReason::no_data, "no scan");
  } else if (update.used < options_.min_returns) {
    carry_on(frame, update, SlamReason::few_returns,
             fmt::format("needs at least {} valid beams, got {} of {}", options_.min_returns, update.used,
                         frame.scan->ranges.size()));
  } else if (!open_submap()) {
    start(frame, scan, update);
  } else {
    follow(frame, scan, update);
  }
  update.milliseconds = whole.lap_ms();
  return update;
}

void HectorSlam::State::start(const Frame& frame, const ScanPoints& scan, SlamUpdate& update) {
  const SE2 pose = guess_.guess(frame.stamp, frame.odometry_from_body).local_from_body;
  graph_.add_submap(pose);
  graph_.add_key_scan({frame.index, frame.stamp, scan, pose, path_m_}, Eigen::Matrix3d::Zero());
  ++revision_;
  update.state = SlamState::tracking;
  update.reason = SlamReason::first_frame;
  update.score = 1.0;
  update.covariance = Matrix6d::Zero();
  update.events.push_back({"submap", graph_.submaps().size() == 1 ? "the first" : "a new one, the last is finished"});
  settle(frame, {.local_from_body = pose, .fits = true}, update);
}

void HectorSlam::State::follow(const Frame& frame, const ScanPoints& scan, SlamUpdate& update) {
  Stopwatch stage;
  ScanGuess guess = guess_.guess(frame.stamp, frame.odometry_from_body);
  guess.after_loss = lost_;
  guess.after_gap = guess_.gap_s(frame.stamp) > 0.0;
  FollowedScan followed = follower_.follow(*open_submap(), scan.points, guess);
  update.times.push_back({"match", stage.lap_ms()});
  // The map goes on in unmapped space from a known pose, or apart from what was mapped before.
  if (lost_ && followed.unmapped && !guess.after_gap) followed.fits = followed.unmapped = false;
  const std::optional<ScanGap> gap = account_for_motion(frame, guess, followed);
  judge(followed, update);
  if (gap) report(*gap, update);
  settle(frame, followed, update);
  if (gap && maps_ && options_.loop_closing) {
    begin_submap_after_gap(frame, scan, followed, update);
  } else if (followed.fits && maps_) {
    extend_map(frame, scan, followed, update);
  }
  update.times.push_back({"map", stage.lap_ms()});
  close_loops(update);
  update.times.push_back({"loops", stage.lap_ms()});
  if (budget_.limited() && maps_) stay_within_budget(update);
}

/// How far the robot came since the last scan, and what may be wrong about that beyond the match.
std::optional<ScanGap> HectorSlam::State::account_for_motion(const Frame& frame, const ScanGuess& guess,
                                                             FollowedScan& followed) {
  const double moved_m = distance_to(followed.local_from_body);
  path_m_ += moved_m;
  const std::optional<ScanGap> gap = gap_before(guess_.gap_s(frame.stamp), guess, followed);
  if (gap) {
    uncertainty_.keep_slip();
    followed.covariance += gap->covariance;
  } else {
    uncertainty_.move(moved_m, guess.measured ? std::optional(guess_.odometry_error()) : std::nullopt,
                      followed.unseen_direction);
  }
  return gap;
}

/// Sets state and reason by the most severe problem.
void HectorSlam::State::judge(const FollowedScan& followed, SlamUpdate& update) {
  update.score = followed.score;
  update.state = lost_ ? SlamState::relocalized : SlamState::tracking;
  lost_ = !followed.fits;
  if (lost_) {
    update.state = SlamState::lost;
    update.reason = SlamReason::poor_match;
    update.detail = fmt::format("match score {:.2f}, needs {:.2f}", followed.score, followed.needs);
  } else {
    judge_fitting(followed, update);
  }
}

void HectorSlam::State::judge_fitting(const FollowedScan& followed, SlamUpdate& update) const {
  update.covariance = uncertainty_.of_pose(followed.local_from_body, followed.covariance + followed.guess_covariance);
  if (followed.unmapped) {
    update.state = SlamState::weak;
    update.reason = SlamReason::poor_match;
    update.detail = fmt::format("needs at least {} beams that end where something is mapped, got {} of {}",
                                options_.min_returns, followed.mapped, update.used);
  } else if (followed.unseen_direction) {
    const Eigen::Vector2d along = followed.local_from_body.rotation().inverse() * *followed.unseen_direction;
    update.state = SlamState::weak;
    update.reason = SlamReason::degenerate;
    update.detail = fmt::format("degenerate: no structure constrains motion at {:.0f} deg from ahead",
                                std::atan(along.y() / along.x()) * 180.0 / M_PI);
  } else if (guess_.odometry_is_given_up()) {
    update.state = SlamState::weak;
    update.reason = SlamReason::odometry_jumped;
    update.detail = "odometry jumped too often to be used, and scans alone do not tell how far a smooth wall goes on";
  } else if (guess_.odometry_jumped()) {
    update.reason = SlamReason::odometry_jumped;
    update.detail = fmt::format("odometry faster than {:g} m/s was rejected", options_.max_speed_m_per_s);
  }
}

/// What was mapped before the gap stays as certain as it is, unless all is in one map.
void HectorSlam::State::report(const ScanGap& gap, SlamUpdate& update) {
  if (!options_.loop_closing) uncertainty_.keep_in_submaps(gap.covariance);
  update.state = SlamState::weak;
  update.reason = SlamReason::gap;
  update.detail = fmt::format("no usable scan for {:.1f} s, and little of this one was mapped before", gap.seconds);
}

/// A frame without a scan to match: its pose is the guess.
void HectorSlam::State::carry_on(const Frame& frame, SlamUpdate& update, SlamReason reason, std::string detail) {
  update.state = graph_.key_scans().empty() ? SlamState::initializing : SlamState::weak;
  update.reason = reason;
  update.detail = std::move(detail);
  const SE2 guess = guess_.guess(frame.stamp, frame.odometry_from_body).local_from_body;
  if (!graph_.key_scans().empty()) path_m_ += distance_to(guess);
  settle(frame, {.local_from_body = guess}, update);
}

double HectorSlam::State::distance_to(const SE2& local_from_body) const {
  return (guess_.last().inverse() * local_from_body).translation().norm();
}

void HectorSlam::State::settle(const Frame& frame, const FollowedScan& followed, SlamUpdate& update) {
  const double scale = guess_.odometry_scale();
  const SE2& local_from_body = followed.local_from_body;
  // Where nothing is mapped, the scan tells a pose only to those that come after it, if they find it in the map.
  if (followed.fits && (maps_ || !followed.unmapped)) {
    guess_.settle(frame.stamp, frame.odometry_from_body, local_from_body, followed.sees_all_directions);
  } else {
    guess_.settle_unseen(frame.stamp, frame.odometry_from_body, local_from_body);
  }
  if (guess_.odometry_scale() != scale)
    update.events.push_back(
        {"odometry_scale", fmt::format("scans move {:.3g} times as far as odometry, which is scaled "
                                       "from here on",
                                       guess_.odometry_scale())});
  const std::size_t keys = graph_.key_scans().size();
  scans_.push_back({frame.stamp, keys > 0 ? keys - 1 : 0, local_from_body});
  update.world_from_body = in_space(graph_.world_from_local() * local_from_body);
}

/// What comes is rigid in itself, but not with what was mapped before: loop closures may move it.
void HectorSlam::State::begin_submap_after_gap(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed,
                                               SlamUpdate& update) {
  for (const auto& submap : graph_.submaps())
    if (!submap->finished()) submap->finish();
  const std::size_t submap = graph_.add_submap(followed.local_from_body);
  uncertainty_.begin_submap(submap, *update.covariance);
  KeyScan key_scan = key_scan_of(frame, scan, followed);
  key_scan.gap_covariance = followed.covariance + followed.guess_covariance;
  scans_.back().key_scan = first_after_gap_ = graph_.add_key_scan(std::move(key_scan), Eigen::Matrix3d::Zero());
  ++revision_;
  update.events.push_back({"submap", fmt::format("{} started after missing scans", submap)});
}

KeyScan HectorSlam::State::key_scan_of(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed) const {
  KeyScan key_scan{frame.index, frame.stamp, scan, followed.local_from_body, path_m_};
  key_scan.assumed_motion = !frame.odometry_from_body || options_.guess != "odometry";
  if (followed.unseen_direction)
    key_scan.unseen_direction = followed.local_from_body.rotation().inverse() * *followed.unseen_direction;
  return key_scan;
}

/// The oldest unfinished one, which has the most scans; null before the first scan and after finish().
Submap* HectorSlam::State::open_submap() {
  for (const auto& submap : graph_.submaps())
    if (!submap->finished()) return submap.get();
  return nullptr;
}

bool HectorSlam::State::moved_enough() const {
  const SE2 moved = graph_.key_scans().back().local_from_body.inverse() * guess_.last();
  const double distance_m = options_.loop_closing ? options_.submap_insert_distance_m : options_.insert_distance_m;
  const double angle_rad = options_.loop_closing ? options_.submap_insert_angle_rad : options_.insert_angle_rad;
  return moved.translation().norm() >= budget_.spacing() * distance_m ||
         std::abs(moved.rotation().angle()) >= budget_.spacing() * angle_rad;
}

void HectorSlam::State::stay_within_budget(SlamUpdate& update) {
  if (budget_.note(map_bytes())) update.events.push_back(budget_.event(map_bytes(), measures()));
  if (budget_.stage() > 0) graph_.search_sparingly();
  while (map_bytes() > budget_.full_bytes()) {
    const std::string given_up = graph_.give_up_redundant();
    if (given_up.empty()) return;
    if (given_up != given_up_) update.events.push_back(budget_.event(map_bytes(), given_up));
    given_up_ = given_up;
  }
}

std::string HectorSlam::State::measures() const {
  if (budget_.stage() == 0) return "";
  return fmt::format("key scans {:g} times as sparse", budget_.spacing());
}

MapMemory HectorSlam::State::map_memory() const { return {map_bytes(), budget_.bytes(), measures()}; }

void HectorSlam::State::extend_map(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed,
                                   SlamUpdate& update) {
  if (!moved_enough()) return;
  const std::size_t key =
      graph_.add_key_scan(key_scan_of(frame, scan, followed), followed.covariance + uncertainty_.slip_of_constraints());
  scans_.back().key_scan = key;
  ++revision_;
  update.events.push_back({"keyframe", fmt::format("{}, after {:.2f} m", key, path_m_)});
  if (options_.loop_closing) advance_submaps(followed, update);
}

/// Submaps overlap by half, so that there is always one with enough scans.
void HectorSlam::State::advance_submaps(const FollowedScan& followed, SlamUpdate& update) {
  std::vector<Submap*> open;
  for (const auto& submap : graph_.submaps()) {
    if (!submap->finished()) open.push_back(submap.get());
  }
  const auto most = static_cast<std::size_t>(options_.submap_scans);
  const bool full = open.front()->key_scans().size() >= most;
  if (full && open.size() > 1) open.front()->finish();
  if (open.back()->key_scans().size() < most / 2) return;
  const Matrix6d covariance =
      uncertainty_.of_submap(followed.local_from_body, followed.covariance + followed.guess_covariance);
  const std::size_t submap = graph_.add_submap(followed.local_from_body);
  uncertainty_.begin_submap(submap, covariance);
  update.events.push_back({"submap", fmt::format("{} started", submap)});
}

void HectorSlam::State::close_loops(SlamUpdate& update) {
  const std::size_t keys = graph_.key_scans().size();
  if (!options_.loop_closing || keys < searched_up_to_ + static_cast<std::size_t>(options_.optimize_every)) return;
  const std::size_t before = graph_.loops().size();
  const int closed = graph_.search_loops(searched_up_to_);
  searched_up_to_ = keys;
  if (closed == 0) return;
  graph_.optimize();
  // Loops of before missing scans say nothing about what came after them.
  uncertainty_.take_over_loops(before, first_after_gap_);
  ++revision_;
  update.world_from_body = in_space(graph_.world_from_local() * guess_.last());
  update.events.push_back({"loop_closed", fmt::format("{} key scans matched with earlier submaps", closed)});
  update.events.push_back({"map_revised", fmt::format("{} key scans in {} submaps", keys, graph_.submaps().size())});
}

std::vector<SlamEvent> HectorSlam::State::finish() {
  std::vector<SlamEvent> events;
  if (!options_.loop_closing || graph_.key_scans().empty()) return events;
  for (const auto& submap : graph_.submaps()) {
    if (!submap->finished() && !submap->key_scans().empty()) submap->finish();
  }
  const int closed = graph_.search_loops(searched_up_to_);
  graph_.optimize();
  const int constrained = graph_.constrain_neighbors();
  graph_.optimize();
  ++revision_;
  events.push_back(
      {"map_revised",
       fmt::format("{} loop closures at the end, {} key scans matched with submaps near them", closed, constrained)});
  return events;
}

HectorSlam::HectorSlam(const HectorOptions& options, TaskPool* pool, std::size_t map_budget_bytes,
                       const std::atomic<bool>* stop)
    : options_(options),
      pool_(pool),
      map_budget_bytes_(map_budget_bytes),
      stop_(stop),
      state_(std::make_unique<State>(options, pool, map_budget_bytes)) {}
HectorSlam::~HectorSlam() = default;
SlamUpdate HectorSlam::process(const Frame& frame) { return state_->process(frame); }
std::vector<SlamEvent> HectorSlam::finish() {
  if (stop_ && stop_->load()) return {{"stopped", "the map is left without the search for loops at the end"}};
  return state_->finish();
}
Trajectory HectorSlam::trajectory() const { return state_->trajectory(); }
std::shared_ptr<const Map> HectorSlam::snapshot() const { return state_->snapshot(); }
MapMemory HectorSlam::map_memory() const { return state_->map_memory(); }
void HectorSlam::reset() { state_ = std::make_unique<State>(options_, pool_, map_budget_bytes_); }

bool HectorSlam::set_mapping(bool on) {
  state_->set_mapping(on);
  return true;
}

}  // namespace rastro
