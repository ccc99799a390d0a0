// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/orb_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "rastro/base/background.h"
#include "rastro/base/error.h"
#include "rastro/base/stopwatch.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/slam/orb/frame_tracker.h"
#include "rastro/slam/orb/frame_way.h"
#include "rastro/slam/orb/initialiser.h"
#include "rastro/slam/orb/local_mapper.h"
#include "rastro/slam/orb/loop_closer.h"
#include "rastro/slam/orb/map_export.h"
#include "rastro/slam/orb/relocaliser.h"
#include "rastro/slam/orb/sensor_choice.h"
#include "rastro/slam/orb/track_association.h"

namespace rastro {
namespace {

using FramePointer = std::shared_ptr<const FeatureFrame>;

SlamReason reason_of(OdometryReason reason) {
  if (reason == OdometryReason::dark_or_blank) return SlamReason::dark_or_blank;
  if (reason == OdometryReason::repeated_frame) return SlamReason::repeated_frame;
  if (reason == OdometryReason::blurred) return SlamReason::blurred;
  if (reason == OdometryReason::gap) return SlamReason::gap;
  return SlamReason::none;
}

/// Of d in truth = exp(d) * camera_from_world to errors of world_from_camera in the world's axes.
Matrix6d in_world_axes(const Matrix6d& covariance, const SE3& camera_from_world) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = camera_from_world.rotation().inverse().matrix();
  const Matrix6d turned = turn * covariance * turn.transpose();
  return 0.5 * (turned + turned.transpose());
}

std::vector<TrackedPoint> points_of(const MapGraph& graph, std::int64_t keyframe) {
  std::vector<TrackedPoint> points;
  const MapKeyframe& seer = graph.keyframe(keyframe);
  for (std::uint32_t i = 0; i < seer.landmarks.size(); ++i) {
    if (seer.landmarks[i] < 0) continue;
    TrackedPoint point;
    point.feature = i;
    point.landmark = seer.landmarks[i];
    point.position = graph.landmark(point.landmark).position;
    points.push_back(point);
  }
  return points;
}

}  // namespace

class OrbSlam::State {
 public:
  State(const OrbSlamOptions& options, const SourceInfo& source, const SlamMeans& means);

  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory() const;
  std::shared_ptr<const Snapshot> snapshot() const;

 private:
  struct MappingResult {
    std::shared_ptr<const MapView> view;
    std::vector<SlamEvent> events;
  };
  struct Pending {
    std::int64_t due = 0;  ///< Number of the first frame that may see it, and ...
    TimeNs due_stamp = 0;  ///< ... its least stamp.
    std::size_t job = 0;
    std::shared_ptr<MappingResult> result;
  };

  void use_map(const SlamMeans& means);
  void keep_map();
  bool relocalise(const FramePointer& frame, SlamUpdate& update);
  void place_lost();
  void say_submap(const TrackResult& tracked, SlamUpdate& update) const;
  void follow_reference(const TrackResult& tracked);
  void look(const Frame& frame, SlamUpdate& update);
  SE3 depth_from_colour(const Frame& frame) const;
  void follow(const FramePointer& frame, const std::vector<FollowedLandmark>& followed, SlamUpdate& update);
  void on_pose(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update);
  void on_loss(const FramePointer& frame, SlamUpdate& update);
  bool begin(const FramePointer& frame, SlamUpdate& update);
  bool begin_from_pair(const StartPair& start, SlamUpdate& update);
  bool begin_from_depth(const FramePointer& frame, SlamUpdate& update);
  int next_submap() const;
  bool proves_wrong(const FramePointer& frame, const TrackResult& tracked);
  void drop_start(const TrackResult& tracked, SlamUpdate& update);
  void track_waiting(const StartPair& start);
  void track_back(std::size_t first);
  void place(const FeatureFrame& frame, const TrackResult& tracked);
  void place_keyframe(const FeatureFrame& frame, std::int64_t keyframe);
  void count_seen(const TrackResult& tracked);
  bool needs_keyframe(const FeatureFrame& frame, const TrackResult& tracked) const;
  KeyframeInput keyframe_input(const FramePointer& frame, const TrackResult& tracked);
  void make_keyframe(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update);
  void map_now(const FramePointer& frame, const TrackResult& tracked);
  void take_results(TimeNs stamp, std::vector<SlamEvent>& events);
  void take_all_results(std::vector<SlamEvent>& events);
  void take_next_result(std::vector<SlamEvent>& events);
  void wait_for_mapping() const { background_.wait_for_all(); }
  MapViewOptions view_options() const { return {options_.local_keyframes, options_.local_landmarks}; }
  std::vector<std::uint32_t> fresh_features(const FeatureFrame& frame, const TrackResult& tracked) const;

  OrbSlamOptions options_;
  SensorChoice sensor_;
  FrameCheck check_;
  FeatureMaker maker_;
  MapGraph graph_;
  LocalMapper mapper_;
  PlaceMemory places_;
  LoopCloser closer_;
  Relocaliser relocaliser_;
  FrameTracker tracker_;
  std::optional<TrackAssociation> tracks_;  ///< Where frontend is tracks.
  Initialiser initialiser_;
  FrameWay way_;
  std::deque<Pending> pending_;
  std::vector<std::int64_t> visible_, found_;
  std::int64_t next_keyframe_ = 0;
  std::int64_t seen_ = 0;           ///< Frames given, of any kind.
  TimeNs last_stamp_ = 0;           ///< Of the last frame with features.
  std::int64_t keyframe_seen_ = 0;  ///< When the last keyframe was made.
  std::int64_t settled_seen_ = 0;   ///< When the way was last lost and found.
  bool tracking_ = false;
  bool exists_ = false;  ///< There is a map.
  bool maps_ = true;     ///< False: only finds its way in a map given.
  int lost_frames_ = 0;
  int trial_frames_ = 0;           ///< That a map just begun from one camera still has to prove itself in.
  int misfits_ = 0;                ///< Of them, in a row.
  std::deque<FramePointer> lost_;  ///< The last ones, to be placed once the way is known again.
  std::optional<MapScale> scale_;  ///< Of a map given.
  MapArchive* archive_;
  const std::atomic<bool>* stop_;
  SE3 last_pose_;                  ///< world_from_camera
  mutable Background background_;  ///< Last: its jobs use what is above.
};

OrbSlam::State::State(const OrbSlamOptions& options, const SourceInfo& source, const SlamMeans& means)
    : options_(options_for(options, source, means.landmark_map.get())),
      sensor_(choose_sensor(options_, source)),
      check_(options_.frame_check),
      maker_(options_, sensor_, means.pool),
      graph_(sensor_.camera, sensor_.sensor, sensor_.baseline, orb_options(options_)),
      mapper_(options_, graph_, means.pool),
      places_(graph_, standard_vocabulary()),
      closer_(options_, graph_, mapper_, places_),
      relocaliser_(options_, graph_, places_),
      tracker_(options_, sensor_.camera, sensor_.sensor, sensor_.baseline),
      initialiser_(options_, sensor_.camera),
      archive_(means.archive),
      stop_(means.stop),
      background_(means.pipelined && means.pool != nullptr && means.pool->threads() > 1) {
  if (options_.frontend == "tracks") tracks_.emplace(options_, sensor_.camera, means.pool);
  if (means.landmark_map) use_map(means);
}

void OrbSlam::State::use_map(const SlamMeans& means) {
  const LandmarkMap& map = *means.landmark_map;
  check_map(map, sensor_, means.extend_map);
  restore(map, sensor_.baseline, graph_);
  places_.update();
  scale_ = map.scale;
  maps_ = means.extend_map;
  exists_ = !map.keyframes.empty();
  next_keyframe_ = map.keyframes.empty() ? 0 : map.keyframes.back()->id + 1;
}

void OrbSlam::State::keep_map() {
  if (archive_ != nullptr && maps_ && pending_.empty() && archive_->wants_map())
    archive_->keep(landmark_map_of(graph_, way_, scale_));
}

SlamUpdate OrbSlam::State::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  ++seen_;
  update.world_from_body = last_pose_;
  take_results(frame.stamp, update.events);
  update.times.push_back({"wait", stage.lap_ms()});
  look(frame, update);
  last_pose_ = update.world_from_body;
  update.milliseconds = whole.lap_ms();
  return update;
}

void OrbSlam::State::look(const Frame& frame, SlamUpdate& update) {
  const FrameCheckResult checked = check_.check(frame.image.view(), frame.stamp);
  update.reason = reason_of(checked.reason);
  update.detail = checked.detail;
  if (!checked.useful() && checked.reason != OdometryReason::blurred) {
    update.state = exists_ ? SlamState::lost : SlamState::initialising;
    if (frame.image.empty()) update.reason = SlamReason::no_data;
    const bool repeated = tracking_ && checked.reason == OdometryReason::repeated_frame;
    if (repeated && way_.repeat_last(frame.index, frame.stamp)) update.state = SlamState::tracking;
    return;
  }
  Stopwatch stage;
  const FramePointer features = maker_.make(frame, depth_from_colour(frame));
  last_stamp_ = frame.stamp;
  update.times.push_back({"features", stage.lap_ms()});
  std::vector<FollowedLandmark> followed;
  if (tracks_) {
    followed = tracks_->follow(frame);
    update.times.push_back({"tracks", stage.lap_ms()});
  }
  if (tracking_) {
    follow(features, followed, update);
  } else {
    on_loss(features, update);
  }
}

/// Depth cameras take both pictures at different instants; the last motion is carried on from one to the other.
SE3 OrbSlam::State::depth_from_colour(const Frame& frame) const {
  const double interval = to_seconds(frame.stamp - last_stamp_), offset = to_seconds(frame.depth_stamp - frame.stamp);
  if (!tracking_ || frame.depth.empty() || !(interval > 0.0) || std::abs(offset) > interval) return {};
  return SE3::exp(offset / interval * tracker_.velocity().log());
}

void OrbSlam::State::follow(const FramePointer& frame, const std::vector<FollowedLandmark>& followed,
                            SlamUpdate& update) {
  Stopwatch stage;
  const TrackResult tracked = tracker_.track(frame, followed);
  update.times.push_back({"track", stage.lap_ms()});
  if (tracked.ok && proves_wrong(frame, tracked)) {
    drop_start(tracked, update);
    return on_loss(frame, update);
  }
  if (tracked.ok) {
    update.state = SlamState::tracking;
    return on_pose(frame, tracked, update);
  }
  update.reason = SlamReason::few_inliers;
  update.detail = fmt::format("{} of {} matches fit, need {}", tracked.inliers, tracked.matches, options_.min_inliers);
  update.world_from_body = tracker_.predicted().inverse();
  tracking_ = false;
  lost_frames_ = trial_frames_ = 0;
  initialiser_.clear();
  on_loss(frame, update);
}

/// Two views may agree on a wrong motion, as near a plane; those that follow do not.
bool OrbSlam::State::proves_wrong(const FramePointer& frame, const TrackResult& tracked) {
  constexpr int least_misfits = 3;
  if (trial_frames_ == 0) return false;
  misfits_ = tracked.mean_squared > options_.init_max_error ? misfits_ + 1 : 0;
  if (misfits_ == least_misfits) return true;
  initialiser_.keep(frame);
  if (--trial_frames_ == 0) initialiser_.clear();
  return false;
}

void OrbSlam::State::drop_start(const TrackResult& tracked, SlamUpdate& update) {
  take_all_results(update.events);
  const int submap = graph_.submap(tracked.reference);
  way_.forget(graph_, submap);
  const std::vector<std::int64_t> keyframes = graph_.keyframe_ids(submap);
  for (const std::int64_t id : keyframes) {
    if (graph_.keyframe(id).parent >= 0) graph_.remove_keyframe(id);
  }
  for (const std::int64_t id : graph_.keyframe_ids(submap)) graph_.remove_root(id);
  tracking_ = false;
  exists_ = graph_.keyframe_count() > 0;
  lost_frames_ = exists_ ? options_.lost_frames : 0;
  trial_frames_ = misfits_ = 0;
  visible_.clear();
  found_.clear();
  update.events.push_back({"start_dropped", fmt::format("submap {} does not fit what came after: squared error {:.1f}, "
                                                        "need {:.1f}; it begins anew",
                                                        submap, tracked.mean_squared, options_.init_max_error)});
}

/// A number that a dropped start has left free is taken again.
int OrbSlam::State::next_submap() const {
  if (!exists_) return 0;
  const int newest = graph_.submap_count() - 1;
  return graph_.keyframe_ids(newest).empty() ? newest : newest + 1;
}

void OrbSlam::State::on_pose(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update) {
  Stopwatch stage;
  update.world_from_body = tracked.camera_from_world.inverse();
  update.covariance = in_world_axes(tracked.covariance, tracked.camera_from_world);
  update.score = static_cast<double>(tracked.inliers) / std::max(1, tracked.matches);
  update.used = tracked.inliers;
  place(*frame, tracked);
  count_seen(tracked);
  if (tracks_) tracks_->learn(*frame, tracked.points);
  say_submap(tracked, update);
  if (!maps_) {
    follow_reference(tracked);
  } else if (needs_keyframe(*frame, tracked)) {
    make_keyframe(frame, tracked, update);
  }
  update.times.push_back({"keyframe", stage.lap_ms()});
}

void OrbSlam::State::say_submap(const TrackResult& tracked, SlamUpdate& update) const {
  const MapView& view = *tracker_.view();
  const int submap = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))].submap;
  if (submap == 0) return;
  if (update.state == SlamState::tracking) update.state = SlamState::weak;
  update.reason = SlamReason::apart;
  update.detail = fmt::format("in submap {}, not tied to the first yet", submap);
}

/// Without mapping, the view goes where the camera goes.
void OrbSlam::State::follow_reference(const TrackResult& tracked) {
  visible_.clear();
  found_.clear();
  if (tracked.reference != tracker_.view()->centre)
    tracker_.set_view(view_of(graph_, tracked.reference, view_options()));
}

void OrbSlam::State::place(const FeatureFrame& frame, const TrackResult& tracked) {
  const MapView& view = *tracker_.view();
  const auto& reference = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))];
  PlacedFrame placed{frame.data().frame,
                     frame.data().stamp,
                     reference.id,
                     tracked.camera_from_world * reference.camera_from_world.inverse(),
                     reference.unit,
                     -1,
                     {}};
  for (const TrackedPoint& point : tracked.points) {
    if (point.landmark < 0) continue;
    placed.seen.push_back({point.landmark, frame.ray(point.feature).cast<float>(),
                           static_cast<float>(frame.right_ray(point.feature)),
                           static_cast<float>(options_.pixel_sigma * graph_.sigma(frame, point.feature))});
  }
  way_.add(placed);
}

void OrbSlam::State::place_keyframe(const FeatureFrame& frame, std::int64_t keyframe) {
  way_.add({frame.data().frame, frame.data().stamp, keyframe, SE3(), graph_.unit(keyframe), keyframe, {}});
}

void OrbSlam::State::count_seen(const TrackResult& tracked) {
  visible_.insert(visible_.end(), tracked.visible.begin(), tracked.visible.end());
  for (const TrackedPoint& point : tracked.points) {
    if (point.landmark >= 0) found_.push_back(point.landmark);
  }
}

bool OrbSlam::State::needs_keyframe(const FeatureFrame& frame, const TrackResult& tracked) const {
  if (settled_seen_ > 0 && seen_ - settled_seen_ < options_.settled_frames) return false;
  const bool overdue = seen_ - keyframe_seen_ > options_.keyframe_frames;
  if (!pending_.empty() && !overdue) return false;
  const MapView& view = *tracker_.view();
  const auto& reference = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))];
  const bool mono = sensor_.sensor == LandmarkSensor::mono;
  const double share = mono ? options_.keyframe_share : options_.keyframe_share_depth;
  if (tracked.inliers < share * reference.landmarks || (overdue && tracked.inliers < reference.landmarks)) return true;
  // Where depth is seen, new ground may come into view while the old is still tracked well.
  if (mono || tracked.inliers >= options_.keyframe_few_points) return false;
  return fresh_features(frame, tracked).size() > static_cast<std::size_t>(options_.keyframe_new_points);
}

std::vector<std::uint32_t> OrbSlam::State::fresh_features(const FeatureFrame& frame, const TrackResult& tracked) const {
  std::vector<std::uint32_t> fresh;
  if (sensor_.sensor == LandmarkSensor::mono) return fresh;
  std::vector<std::uint8_t> taken(frame.size(), 0);
  for (const TrackedPoint& point : tracked.points) taken[point.feature] = 1;
  const double far = options_.far_baselines * sensor_.baseline;
  for (std::uint32_t i = 0; i < frame.size(); ++i) {
    if (taken[i] == 0 && std::isfinite(frame.right_pixel(i)) && static_cast<double>(frame.data().depths[i]) <= far)
      fresh.push_back(i);
  }
  return fresh;
}

KeyframeInput OrbSlam::State::keyframe_input(const FramePointer& frame, const TrackResult& tracked) {
  const MapView& view = *tracker_.view();
  const auto& reference = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))];
  KeyframeInput input{frame->with_id(next_keyframe_++),
                      reference.id,
                      tracked.camera_from_world * reference.camera_from_world.inverse(),
                      reference.unit,
                      tracked.points,
                      std::move(visible_),
                      std::move(found_)};
  visible_.clear();
  found_.clear();
  keyframe_seen_ = seen_;
  way_.set_keyframe(frame->data().frame, input.frame->data().id);
  return input;
}

void OrbSlam::State::make_keyframe(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update) {
  const auto input = std::make_shared<KeyframeInput>(keyframe_input(frame, tracked));
  const std::int64_t id = input->frame->data().id;
  tracker_.add_fresh(id, input->frame, tracked.camera_from_world, fresh_features(*frame, tracked));
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  const auto result = std::make_shared<MappingResult>();
  const std::size_t job = background_.submit([this, input, result, id] {
    mapper_.add(*input);
    if (options_.loops == "on") {
      if (const auto loop = closer_.consider(id)) result->events.push_back(loop->event());
    }
    result->view = view_of(graph_, id, view_options());
  });
  const TimeNs due_stamp = frame->data().stamp + from_seconds(options_.backend_delay_s);
  pending_.push_back({seen_ + options_.backend_delay_frames, due_stamp, job, result});
}

/// The same without a later frame to hand the result over to.
void OrbSlam::State::map_now(const FramePointer& frame, const TrackResult& tracked) {
  const KeyframeInput input = keyframe_input(frame, tracked);
  mapper_.add(input);
  tracker_.set_view(view_of(graph_, input.frame->data().id, view_options()));
}

void OrbSlam::State::take_results(TimeNs stamp, std::vector<SlamEvent>& events) {
  const auto due = [&](const Pending& next) {
    const bool whatever_the_clock = next.due + options_.keyframe_frames <= seen_;
    return next.due <= seen_ && (next.due_stamp <= stamp || whatever_the_clock);
  };
  while (!pending_.empty() && due(pending_.front())) take_next_result(events);
}

void OrbSlam::State::take_all_results(std::vector<SlamEvent>& events) {
  while (!pending_.empty()) take_next_result(events);
}

void OrbSlam::State::take_next_result(std::vector<SlamEvent>& events) {
  const Pending pending = pending_.front();
  pending_.pop_front();
  background_.wait(pending.job);
  events.insert(events.end(), pending.result->events.begin(), pending.result->events.end());
  if (tracking_) tracker_.set_view(pending.result->view);
  keep_map();
}

void OrbSlam::State::on_loss(const FramePointer& frame, SlamUpdate& update) {
  Stopwatch stage;
  ++lost_frames_;
  update.state = exists_ ? SlamState::lost : SlamState::initialising;
  if (exists_ && update.reason == SlamReason::none) update.reason = SlamReason::not_found;
  const bool found = exists_ && relocalise(frame, update);
  if (exists_) update.times.push_back({"relocalise", stage.lap_ms()});
  if (found || !maps_) return;
  begin(frame, update);
  update.times.push_back({"start", stage.lap_ms()});
}

bool OrbSlam::State::relocalise(const FramePointer& frame, SlamUpdate& update) {
  take_all_results(update.events);
  lost_.push_back(frame);
  if (lost_.size() > static_cast<std::size_t>(options_.init_frames)) lost_.pop_front();
  if (options_.loops != "on") places_.update();
  const auto relocation = relocaliser_.find(*frame);
  if (!relocation) return false;
  tracker_.set_view(view_of(graph_, relocation->keyframe, view_options()));
  tracker_.restart(relocation->camera_from_world, {}, frame);
  const TrackResult tracked = tracker_.track_from(frame, relocation->camera_from_world);
  if (!tracked.ok) return false;
  tracking_ = true;
  lost_.pop_back();
  place_lost();
  settled_seen_ = seen_;
  update.state = SlamState::relocalised;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.events.push_back({"relocalised", fmt::format("in keyframe {} with {} landmarks after {} frames",
                                                      relocation->keyframe, tracked.inliers, lost_frames_)});
  on_pose(frame, tracked, update);
  initialiser_.clear();
  return true;
}

/// Frames before the one that was found again, as far back as they can be followed.
void OrbSlam::State::place_lost() {
  FrameTracker backwards = tracker_;
  while (!lost_.empty()) {
    const TrackResult tracked = backwards.track(lost_.back());
    if (!tracked.ok) break;
    place(*lost_.back(), tracked);
    lost_.pop_back();
  }
  lost_.clear();
}

bool OrbSlam::State::begin(const FramePointer& frame, SlamUpdate& update) {
  if (sensor_.sensor != LandmarkSensor::mono) return begin_from_depth(frame, update);
  const auto start = initialiser_.add(frame);
  if (!exists_) update.reason = initialiser_.frames().size() < 2 ? SlamReason::first_frame : SlamReason::too_few_points;
  update.detail = initialiser_.detail();
  if (!start || (exists_ && lost_frames_ < options_.lost_frames)) return false;
  return begin_from_pair(*start, update);
}

bool OrbSlam::State::begin_from_pair(const StartPair& start, SlamUpdate& update) {
  take_all_results(update.events);
  const FramePointer first = initialiser_.frames()[start.first]->with_id(next_keyframe_);
  const FramePointer second = initialiser_.frames()[start.second]->with_id(next_keyframe_ + 1);
  next_keyframe_ += 2;
  const int submap = next_submap();
  if (!mapper_.start(first, second, start.second_from_first, start.pairs, start.points, submap)) {
    update.detail = fmt::format("fewer than {} points left after adjustment", options_.init_points);
    return false;
  }
  exists_ = tracking_ = true;
  keyframe_seen_ = seen_;
  settled_seen_ = 0;
  tracker_.set_view(view_of(graph_, second->data().id, view_options()));
  place_keyframe(*first, first->data().id);
  place_keyframe(*second, second->data().id);
  update.events.push_back({"submap", fmt::format("{} begun from frames {} and {} with {} points", submap,
                                                 first->data().frame, second->data().frame, graph_.landmark_count())});
  track_waiting(start);
  update.state = SlamState::tracking;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.world_from_body = tracker_.last_pose().inverse();
  trial_frames_ = options_.init_trial_frames;
  misfits_ = 0;
  if (trial_frames_ == 0) initialiser_.clear();
  return true;
}

/// The frames between the two, those before them, and on from the second.
void OrbSlam::State::track_waiting(const StartPair& start) {
  const std::int64_t first = graph_.keyframe_ids().back() - 1, second = first + 1;
  const auto& frames = initialiser_.frames();
  tracker_.restart(graph_.keyframe(first).camera_from_world, points_of(graph_, first), graph_.keyframe(first).frame);
  track_back(start.first);
  tracker_.restart(graph_.camera_from_world(first), points_of(graph_, first), graph_.keyframe(first).frame);
  for (std::size_t i = start.first + 1; i < start.second; ++i) {
    const TrackResult tracked = tracker_.track(frames[i]);
    if (tracked.ok) place(*frames[i], tracked);
  }
  if (tracker_.track(frames[start.second]).ok) return;
  tracker_.restart(graph_.camera_from_world(second), points_of(graph_, second), graph_.keyframe(second).frame);
}

void OrbSlam::State::track_back(std::size_t first) {
  const auto& frames = initialiser_.frames();
  for (std::size_t i = first; i-- > 0;) {
    const TrackResult tracked = tracker_.track(frames[i]);
    if (!tracked.ok) break;
    place(*frames[i], tracked);
    if (needs_keyframe(*frames[i], tracked)) map_now(frames[i], tracked);
  }
}

bool OrbSlam::State::begin_from_depth(const FramePointer& frame, SlamUpdate& update) {
  if (exists_ && lost_frames_ < options_.lost_frames) return false;
  const auto known =
      std::count_if(frame->data().depths.begin(), frame->data().depths.end(), [](float depth) { return depth > 0.0F; });
  if (known < options_.start_depth_points) {
    update.reason = SlamReason::too_few_points;
    update.detail = fmt::format("{} features with depth, need {}", known, options_.start_depth_points);
    return false;
  }
  take_all_results(update.events);
  const FramePointer keyframe = frame->with_id(next_keyframe_++);
  const std::int64_t id = keyframe->data().id;
  const int submap = next_submap();
  mapper_.start(keyframe, submap);
  exists_ = tracking_ = true;
  keyframe_seen_ = seen_;
  settled_seen_ = 0;
  tracker_.set_view(view_of(graph_, id, view_options()));
  tracker_.restart(SE3(), points_of(graph_, id), keyframe);
  place_keyframe(*keyframe, id);
  update.state = SlamState::tracking;
  update.reason = SlamReason::none;
  update.world_from_body = SE3();
  update.events.push_back({"submap", fmt::format("{} begun with {} points", submap, known)});
  return true;
}

std::vector<SlamEvent> OrbSlam::State::finish() {
  std::vector<SlamEvent> events;
  take_all_results(events);
  wait_for_mapping();
  if (!exists_) return events;
  const bool in_haste = stop_ != nullptr && stop_->load();
  if (maps_ && !in_haste && options_.final_iterations > 0 &&
      graph_.keyframe_count() <= static_cast<std::size_t>(options_.final_keyframes)) {
    for (int submap = 0; submap < graph_.submap_count(); ++submap)
      mapper_.adjust_all(submap, options_.final_iterations);
  }
  way_.settle(graph_, options_.min_inliers / 2);
  keep_map();
  return events;
}

Trajectory OrbSlam::State::trajectory() const {
  wait_for_mapping();
  return exists_ ? way_.trajectory(graph_, way_.largest_submap(graph_)) : Trajectory();
}

std::shared_ptr<const Snapshot> OrbSlam::State::snapshot() const {
  wait_for_mapping();
  return snapshot_of(graph_, way_, scale_);
}

OrbSlam::OrbSlam(const OrbSlamOptions& options, const SourceInfo& source, const SlamMeans& means)
    : state_(std::make_unique<State>(options, source, means)) {}
OrbSlam::~OrbSlam() = default;
SlamUpdate OrbSlam::process(const Frame& frame) { return state_->process(frame); }
std::vector<SlamEvent> OrbSlam::finish() { return state_->finish(); }
Trajectory OrbSlam::trajectory() const { return state_->trajectory(); }
std::shared_ptr<const Snapshot> OrbSlam::snapshot() const { return state_->snapshot(); }

}  // namespace rastro
