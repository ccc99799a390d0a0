// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/orb_slam.h"

#include <utility>

#include "rastro/base/stopwatch.h"
#include "rastro/slam/motion_check.h"
#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/map/map_export.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/tracking.h"

namespace rastro {

/// Tracking, and the jobs beside it.
class OrbSlam::State {
 public:
  State(const OrbSlamOptions& options, const SourceInfo& source, const SlamContext& context,
        const OrbMethodParts& parts);

  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory() const;
  std::shared_ptr<const Map> snapshot() const;
  bool set_mapping(bool on);
  const std::vector<FeatureObservation>& observations() const { return tracking_.observations(); }
  std::int64_t dropped_frames() const { return pipeline_.dropped_frames(); }
  MapMemory map_memory() const;

 private:
  void use_map(const SlamContext& context);

  OrbSession session_;
  FrameTracker tracker_;
  KeyframePipeline pipeline_;
  Tracking tracking_;
  MotionCheck motion_check_;
  SE3 last_pose_;                  ///< world_from_camera
  std::vector<SlamEvent> events_;  ///< Not reported yet.
};

OrbSlam::State::State(const OrbSlamOptions& options, const SourceInfo& source, const SlamContext& context,
                      const OrbMethodParts& parts)
    : session_(options, source, context, parts),
      tracker_(session_.options, session_.sensor.camera, session_.sensor.sensor, session_.sensor.baseline),
      pipeline_(session_, tracker_, context),
      tracking_(session_, tracker_, pipeline_, context.pool),
      motion_check_(session_.mono() ? 0.0 : session_.options.max_acceleration) {
  if (context.map) use_map(context);
}

void OrbSlam::State::use_map(const SlamContext& context) {
  const Map& map = *context.map;
  check_map(map, session_.sensor, context.extend_map, session_.method);
  session_.given = restore(map, session_.sensor.baseline, session_.graph);
  pipeline_.database().update();
  session_.mapping = context.extend_map;
  session_.has_map = !map.keyframes.empty();
  session_.initial_pose = context.initial_pose;
  session_.next_keyframe = session_.graph.newest_keyframe() + 1;
}

SlamUpdate OrbSlam::State::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  update.world_from_body = last_pose_;
  ++session_.frame_number;
  update.events = std::exchange(events_, {});
  pipeline_.take_results(frame.stamp, update.events);
  update.times.push_back({"wait", stage.lap_ms()});
  tracking_.process(frame, update);
  if (corrects_map(update.events)) motion_check_.forget();
  motion_check_.check(update);
  last_pose_ = update.world_from_body;
  update.world_from_body = update.world_from_body * session_.sensor.camera_from_left();
  if (session_.has_map) pipeline_.archive_map();
  update.milliseconds = whole.lap_ms();
  return update;
}

std::vector<SlamEvent> OrbSlam::State::finish() {
  std::vector<SlamEvent> events;
  pipeline_.finish(events);
  return events;
}

Trajectory OrbSlam::State::trajectory() const {
  pipeline_.wait();
  if (!session_.has_map) return {};
  const FrameTrajectory& frames = session_.trajectory;
  // In a given map, poses are in its frame and its unit or none: those of a new submap have neither.
  const int submap = session_.given ? 0 : frames.largest_submap(session_.graph);
  Trajectory trajectory = frames.trajectory(session_.graph, submap);
  for (StampedPose& pose : trajectory) pose.world_from_body = pose.world_from_body * session_.sensor.camera_from_left();
  return trajectory;
}

std::shared_ptr<const Map> OrbSlam::State::snapshot() const {
  pipeline_.wait();
  return map_of(session_.graph, session_.trajectory, session_.given, session_.method);
}

MapMemory OrbSlam::State::map_memory() const {
  pipeline_.wait();
  return pipeline_.map_memory();
}

/// Localization reads the graph on the tracking thread: no job may be in flight.
bool OrbSlam::State::set_mapping(bool on) {
  if (!on && !session_.has_map) return false;
  if (on == session_.mapping) return true;  // jobs read it
  if (!on) pipeline_.pause(events_);
  session_.mapping = on;
  return true;
}

OrbSlam::OrbSlam(const OrbSlamOptions& options, const SourceInfo& source, const SlamContext& context,
                 const OrbMethodParts& parts)
    : options_(options),
      source_(source),
      context_(context),
      parts_(parts),
      state_(std::make_unique<State>(options, source, context, parts)) {}

OrbSlam::~OrbSlam() = default;
SlamUpdate OrbSlam::process(const Frame& frame) { return state_->process(frame); }
std::vector<SlamEvent> OrbSlam::finish() { return state_->finish(); }
Trajectory OrbSlam::trajectory() const { return state_->trajectory(); }
std::shared_ptr<const Map> OrbSlam::snapshot() const { return state_->snapshot(); }
bool OrbSlam::set_mapping(bool on) { return state_->set_mapping(on); }
std::vector<FeatureObservation> OrbSlam::observations() const { return state_->observations(); }
std::int64_t OrbSlam::dropped_frames() const { return state_->dropped_frames(); }
MapMemory OrbSlam::map_memory() const { return state_->map_memory(); }

void OrbSlam::reset() {
  state_.reset();  // its jobs end before the next ones begin
  state_ = std::make_unique<State>(options_, source_, context_, parts_);
}

}  // namespace rastro
