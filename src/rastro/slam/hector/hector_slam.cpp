// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/hector_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/backend/map_uncertainty.h"
#include "rastro/base/checked_options.h"
#include "rastro/base/error.h"
#include "rastro/base/stopwatch.h"
#include "rastro/map/graph/planar.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/slam/hector/final_map.h"
#include "rastro/slam/hector/motion_guess.h"
#include "rastro/slam/hector/scan_follower.h"
#include "rastro/slam/hector/submap_graph.h"
#include "rastro/slam/map_budget.h"

namespace rastro {
namespace {

/// Covariance of (x, y, angle) in axes rotated by `rotation`.
Eigen::Matrix3d in_rotated_axes(const Eigen::Matrix3d& covariance, const SO2& rotation) {
  Eigen::Matrix3d by = Eigen::Matrix3d::Identity();
  by.topLeftCorner<2, 2>() = rotation.matrix();
  return by * covariance * by.transpose();
}

}  // namespace

class HectorSlam::State {
 public:
  State(const HectorOptions& options, TaskPool* pool, std::size_t map_budget_bytes)
      : options_(checked(options, "hector options")),
        follower_(options_),
        guess_(options_),
        graph_(options_, pool),
        budget_(map_budget_bytes) {}

  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory() const;
  std::shared_ptr<const Map> snapshot() const;
  void set_mapping(bool on) { maps_ = on; }
  MapMemory map_memory() const;

 private:
  void follow(const Frame& frame, const ScanPoints& scan, SlamUpdate& update);
  void start(const Frame& frame, const ScanPoints& scan, SlamUpdate& update);
  void judge(const FollowedScan& followed, SlamUpdate& update);
  void bridge_gap(const Frame& frame, const ScanGuess& guess, FollowedScan& followed, SlamUpdate& update);
  void begin_submap_after_gap(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed,
                              SlamUpdate& update);
  void keep_in_submaps(const Eigen::Matrix3d& in_local);
  void carry_on(const Frame& frame, SlamUpdate& update, SlamReason reason, std::string detail);
  void extend_map(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed, SlamUpdate& update);
  Eigen::Matrix3d with_unseen_path(const FollowedScan& followed) const;
  Matrix6d covariance_of(const SE2& local_from_body, const Eigen::Matrix3d& in_submap);
  void keep_slip();
  void take_over_certainty(std::size_t first_loop);
  bool moved_enough() const;
  Submap* open_submap();
  void advance_submaps(const Eigen::Matrix3d& in_submap, SlamUpdate& update);
  void close_loops(SlamUpdate& update);
  std::size_t map_bytes() const { return graph_.bytes() + scans_.size() * sizeof(PosedScan); }
  std::string measures() const;
  void stay_within_budget(SlamUpdate& update);
  void settle(const Frame& frame, const SE2& local_from_body, SlamUpdate& update, bool by_scan = false);

  HectorOptions options_;
  ScanFollower follower_;
  MotionGuess guess_;
  SubmapGraph graph_;
  MapUncertainty uncertainty_;  ///< Of the submaps.
  MapBudget budget_;
  std::string given_up_;  ///< The last measure to save memory; reported when it changes.
  std::vector<PosedScan> scans_;
  std::size_t first_after_gap_ = 0;  ///< Key scan that followed the last missing scans.
  std::size_t searched_up_to_ = 0;   ///< Loop closures of key scans before this one were searched for in older submaps.
  double path_m_ = 0.0;
  double unseen_path_m_ = 0.0;                      ///< Path length since all directions were last observable.
  Eigen::Vector2d slip_ = Eigen::Vector2d::Zero();  ///< Standard deviation gathered on it, local axes.
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
  graph_.add_key_scan({frame.index, frame.stamp, scan, pose, 0.0}, Eigen::Matrix3d::Zero());
  ++revision_;
  update.state = SlamState::tracking;
  update.reason = SlamReason::first_frame;
  update.score = 1.0;
  update.covariance = Matrix6d::Zero();
  update.events.push_back({"submap", graph_.submaps().size() == 1 ? "the first" : "a new one, the last is finished"});
  settle(frame, pose, update);
}

void HectorSlam::State::follow(const Frame& frame, const ScanPoints& scan, SlamUpdate& update) {
  Stopwatch stage;
  const ScanGuess guess = guess_.guess(frame.stamp, frame.odometry_from_body);
  FollowedScan followed = follower_.follow(*open_submap(), scan.points, guess);
  update.times.push_back({"match", stage.lap_ms()});
  judge(followed, update);
  if (followed.fits) bridge_gap(frame, guess, followed, update);
  const double path_m = (guess_.last().inverse() * followed.local_from_body).translation().norm();
  path_m_ += path_m;
  if (!followed.unseen_direction && unseen_path_m_ > 0.0) keep_slip();
  unseen_path_m_ = followed.unseen_direction ? unseen_path_m_ + path_m : 0.0;
  if (followed.unseen_direction) slip_ = options_.odometry_sigma_share * unseen_path_m_ * *followed.unseen_direction;
  settle(frame, followed.local_from_body, update, followed.fits && followed.sees_all_directions);
  if (followed.fits && maps_ && update.reason == SlamReason::gap && options_.loop_closing) {
    begin_submap_after_gap(frame, scan, followed, update);
  } else if (followed.fits && maps_) {
    extend_map(frame, scan, followed, update);
  }
  update.times.push_back({"map", stage.lap_ms()});
  close_loops(update);
  update.times.push_back({"loops", stage.lap_ms()});
  if (budget_.limited() && maps_) stay_within_budget(update);
}

/// Sets state and reason by the most severe problem.
void HectorSlam::State::judge(const FollowedScan& followed, SlamUpdate& update) {
  update.score = followed.score;
  update.state = lost_ ? SlamState::relocalized : SlamState::tracking;
  if (!followed.fits) {
    update.state = SlamState::lost;
    update.reason = SlamReason::poor_match;
    update.detail = fmt::format("match score {:.2f}, needs {:.2f}", followed.score, options_.min_score);
  } else {
    update.covariance = covariance_of(followed.local_from_body, followed.covariance);
    if (followed.unseen_direction) {
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
  lost_ = !followed.fits;
}

/// A frame without a scan to match: its pose is the guess.
void HectorSlam::State::carry_on(const Frame& frame, SlamUpdate& update, SlamReason reason, std::string detail) {
  update.state = graph_.key_scans().empty() ? SlamState::initializing : SlamState::weak;
  update.reason = reason;
  update.detail = std::move(detail);
  settle(frame, guess_.guess(frame.stamp, frame.odometry_from_body).local_from_body, update);
}

void HectorSlam::State::settle(const Frame& frame, const SE2& local_from_body, SlamUpdate& update, bool by_scan) {
  const double scale = guess_.odometry_scale();
  guess_.settle(frame.stamp, frame.odometry_from_body, local_from_body, by_scan);
  if (guess_.odometry_scale() != scale)
    update.events.push_back(
        {"odometry_scale", fmt::format("scans move {:.3g} times as far as odometry, which is scaled "
                                       "from here on",
                                       guess_.odometry_scale())});
  const std::size_t keys = graph_.key_scans().size();
  scans_.push_back({frame.stamp, keys > 0 ? keys - 1 : 0, local_from_body});
  update.world_from_body = in_space(graph_.world_from_local() * local_from_body);
}

/// After missing scans the surroundings are mostly new: they fit, but what carried the pose there is the guess.
void HectorSlam::State::bridge_gap(const Frame& frame, const ScanGuess& guess, FollowedScan& followed,
                                   SlamUpdate& update) {
  constexpr double known_place = 0.75;  // the score where most of a scan was mapped before
  const double gap_s = guess_.gap_s(frame.stamp);
  if (gap_s == 0.0 || followed.score >= known_place) return;
  // Odometry gathers errors on the whole way, of which only the ends are known.
  constexpr double drift_m_per_s = 0.05, drift_rad_per_s = 0.005;
  const double sigma_m = std::max(guess.sigma_m, drift_m_per_s * gap_s);
  const Eigen::Vector3d sigma(sigma_m, sigma_m, std::max(guess.sigma_rad, drift_rad_per_s * gap_s));
  const Eigen::Matrix3d unknown = sigma.cwiseAbs2().asDiagonal();
  followed.covariance += unknown;
  if (!options_.loop_closing) keep_in_submaps(unknown);
  update.covariance = covariance_of(followed.local_from_body, followed.covariance);
  update.state = SlamState::weak;
  update.reason = SlamReason::gap;
  update.detail = fmt::format("no scan for {:.1f} s, and little of this one was mapped before", gap_s);
}

/// What comes is rigid in itself, but not with what was mapped before: loop closures may move it.
void HectorSlam::State::begin_submap_after_gap(const Frame& frame, const ScanPoints& scan, const FollowedScan& followed,
                                               SlamUpdate& update) {
  for (const auto& submap : graph_.submaps())
    if (!submap->finished()) submap->finish();
  const std::size_t submap = graph_.add_submap(followed.local_from_body);
  uncertainty_.set(static_cast<std::int64_t>(submap), in_space(graph_.world_from_submap(submap)).translation(),
                   *update.covariance);
  KeyScan key_scan{frame.index, frame.stamp, scan, followed.local_from_body, path_m_};
  key_scan.gap_sigma = followed.covariance.diagonal().cwiseSqrt();
  scans_.back().key_scan = first_after_gap_ = graph_.add_key_scan(std::move(key_scan), Eigen::Matrix3d::Zero());
  ++revision_;
  update.events.push_back({"submap", fmt::format("{} started after missing scans", submap)});
}

/// Along an unobservable direction odometry errors accumulate: wheel slip is the same in each scan.
Eigen::Matrix3d HectorSlam::State::with_unseen_path(const FollowedScan& followed) const {
  Eigen::Matrix3d covariance = followed.covariance;
  if (followed.unseen_direction) covariance.topLeftCorner<2, 2>() += slip_ * slip_.transpose();
  return covariance;
}

/// What was not seen while the scans were inserted stays in the submaps that they are in.
void HectorSlam::State::keep_slip() {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>() = slip_ * slip_.transpose();
  keep_in_submaps(covariance);
}

/// Of (x, y, angle) in local axes, for all that is in the unfinished submaps.
void HectorSlam::State::keep_in_submaps(const Eigen::Matrix3d& in_local) {
  Eigen::Matrix3d covariance = in_local;
  const Eigen::Matrix2d turn = graph_.world_from_local().rotation().matrix();
  covariance.topLeftCorner<2, 2>() = turn * in_local.topLeftCorner<2, 2>() * turn.transpose();
  for (std::size_t s = 0; s < graph_.submaps().size(); ++s) {
    if (graph_.submaps()[s]->finished()) continue;
    const Eigen::Vector3d position = in_space(graph_.world_from_submap(s)).translation();
    const auto submap = static_cast<std::int64_t>(s);
    uncertainty_.set(submap, position, uncertainty_.of_pose(submap, position, in_space(covariance)));
  }
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
  KeyScan key_scan{frame.index, frame.stamp, scan, followed.local_from_body, path_m_};
  if (followed.unseen_direction)
    key_scan.unseen_direction = followed.local_from_body.rotation().inverse() * *followed.unseen_direction;
  const std::size_t key = graph_.add_key_scan(std::move(key_scan), with_unseen_path(followed));
  scans_.back().key_scan = key;
  ++revision_;
  update.events.push_back({"keyframe", fmt::format("{}, after {:.2f} m", key, path_m_)});
  if (options_.loop_closing) advance_submaps(with_unseen_path(followed), update);
}

/// From the covariance of a scan in the submap that it was matched with, in local axes.
Matrix6d HectorSlam::State::covariance_of(const SE2& local_from_body, const Eigen::Matrix3d& in_submap) {
  // Cells hold the walls to a part of their size, the same for all beams of a scan and all scans of a submap.
  constexpr double share_of_cell = 0.6, sigma_rad = 0.002;
  const double sigma_m = share_of_cell * options_.cell_m;
  const Eigen::Matrix3d with_cells =
      in_submap +
      Eigen::Matrix3d(Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal());
  const SE2 world_from_local = graph_.world_from_local();
  std::size_t open = 0;
  while (open + 1 < graph_.submaps().size() && graph_.submaps()[open]->finished()) ++open;
  return uncertainty_.of_pose(static_cast<std::int64_t>(open),
                              in_space(world_from_local * local_from_body).translation(),
                              in_space(in_rotated_axes(with_cells, world_from_local.rotation())));
}

/// Submaps overlap by half, so that there is always one with enough scans.
void HectorSlam::State::advance_submaps(const Eigen::Matrix3d& in_submap, SlamUpdate& update) {
  std::vector<Submap*> open;
  for (const auto& submap : graph_.submaps()) {
    if (!submap->finished()) open.push_back(submap.get());
  }
  const auto most = static_cast<std::size_t>(options_.submap_scans);
  const bool full = open.front()->key_scans().size() >= most;
  if (full && open.size() > 1) open.front()->finish();
  if (open.back()->key_scans().size() < most / 2) return;
  const Matrix6d covariance = covariance_of(guess_.last(), in_submap);
  const std::size_t submap = graph_.add_submap(guess_.last());
  uncertainty_.set(static_cast<std::int64_t>(submap), in_space(graph_.world_from_submap(submap)).translation(),
                   covariance);
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
  take_over_certainty(before);
  ++revision_;
  update.world_from_body = in_space(graph_.world_from_local() * guess_.last());
  update.events.push_back({"loop_closed", fmt::format("{} key scans matched with earlier submaps", closed)});
  update.events.push_back({"map_revised", fmt::format("{} key scans in {} submaps", keys, graph_.submaps().size())});
}

/// What a loop closure ties the newest submaps to may be more certain than they are. One from before missing scans says
/// nothing about what came after them.
void HectorSlam::State::take_over_certainty(std::size_t first_loop) {
  const Eigen::Vector3d sigma(options_.loop_sigma_m, options_.loop_sigma_m, options_.loop_sigma_rad);
  const Eigen::Matrix3d of_loops = sigma.cwiseAbs2().asDiagonal();
  for (std::size_t l = first_loop; l < graph_.loops().size(); ++l) {
    const ClosedLoop& loop = graph_.loops()[l];
    if (loop.key_scan < first_after_gap_) continue;
    const SE2 pose = graph_.world_from_key_scan(loop.key_scan);
    const Eigen::Vector3d position = in_space(pose).translation();
    const SO2 world_from_submap = graph_.world_from_submap(loop.submap).rotation();
    const Matrix6d covariance =
        uncertainty_.of_pose(static_cast<std::int64_t>(loop.submap), position,
                             in_space(in_rotated_axes(loop.covariance + of_loops, world_from_submap)));
    for (std::size_t s = 0; s < graph_.submaps().size(); ++s)
      if (!graph_.submaps()[s]->finished()) uncertainty_.reduce(static_cast<std::int64_t>(s), position, covariance);
  }
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

Trajectory HectorSlam::State::trajectory() const {
  Trajectory trajectory;
  for (const StampedPlanarPose& pose : scan_poses(scans_, graph_))
    trajectory.push_back({pose.stamp, in_space(pose.pose)});
  // Scans are processed in the order of the log; in some logs the stamps are not in this order.
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  return trajectory;
}

std::shared_ptr<const Map> HectorSlam::State::snapshot() const {
  auto map = std::make_shared<Map>();
  map->method = "hector";
  map->revision = revision_;
  auto scans = std::make_shared<ScanLayer>();
  scans->cell_m = options_.cell_m;
  scans->model = {options_.occupied_probability, options_.free_probability};
  for (std::size_t k = 0; k < graph_.key_scans().size(); ++k) {
    const KeyScan& key_scan = graph_.key_scans()[k];
    const auto id = static_cast<KeyframeId>(k);
    map->keyframes.push_back(
        {id, key_scan.frame, key_scan.stamp, 0, in_space(graph_.world_from_key_scan(k)), 0, id - 1, 1.0});
    scans->of[id] = std::make_shared<KeyframeScans>(1, key_scan.scan);
  }
  map->layers.put<ScanLayer>(std::move(scans));
  map->constraints = graph_.constraints();
  const std::vector<StampedPlanarPose> poses = scan_poses(scans_, graph_);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::size_t key = scans_[i].key_scan;
    map->frames.push_back({poses[i].stamp, static_cast<KeyframeId>(key),
                           in_space(graph_.world_from_key_scan(key).inverse() * poses[i].pose)});
  }
  const TimeNs first = scans_.empty() ? 0 : scans_.front().stamp, last = scans_.empty() ? 0 : scans_.back().stamp;
  map->sessions.push_back({0, 0, "", first, last, {true, 0.0, "laser"}});
  return map;
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
