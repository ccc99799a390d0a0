// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "rastro/backend/rgbd/frame_report.h"
#include "rastro/base/stopwatch.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/slam/lsd/initialization/convergence_check.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/lsd_motion.h"
#include "rastro/slam/lsd/lsd_pipeline.h"
#include "rastro/slam/lsd/lsd_relocalization.h"
#include "rastro/slam/lsd/lsd_start.h"
#include "rastro/slam/lsd/pose_search.h"
#include "rastro/slam/motion_check.h"

namespace rastro {
class LsdSlam::State {
 public:
  State(const LsdOptions& options, const LsdSensor& sensor, const SlamContext& context);
  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory();
  std::shared_ptr<const Map> snapshot() { return mapping_.settled().graph().snapshot(sensor_); }
  MapMemory map_memory() const { return mapping_.memory(); }
  std::int64_t dropped_frames() const { return mapping_.dropped_frames(); }

 private:
  using SharedFrame = std::shared_ptr<const LsdFrame>;
  bool is_usable(const Frame& frame, SlamUpdate& update);
  void on_unusable_frame();
  void repeat_pose(const Frame& frame, SlamUpdate& update);
  void start(const LsdFrame& frame, SlamUpdate& update);
  void check_convergence(const LsdFrame& frame, SlamUpdate& update);
  void doubt(SlamUpdate& update) const;
  JudgedAlignment track(const LsdFrame& frame, SlamUpdate& update);
  struct Followed {
    ImageAlignment alignment;
    bool is_sure = true;
  };
  std::optional<Followed> follow(const SharedFrame& frame, SlamUpdate& update);
  bool check_motion(SlamUpdate& update);
  void accept(const LsdFrame& frame, const ImageAlignment& tracked, SlamUpdate& update);
  void on_loss(const LsdFrame& frame, const PoseVerdict& verdict, SlamUpdate& update);
  bool relocalize(const LsdFrame& frame, bool was_tried, SlamUpdate& update);

  LsdOptions options_;
  LsdSensor sensor_;
  LsdFrameMaker frames_;
  FrameCheck check_;
  LsdStart start_;
  ConvergenceCheck convergence_;  ///< Of depths that begin at random.
  PoseSearch search_;
  LsdMotion motion_;
  std::int64_t number_ = 0;  ///< Of the frame, counting all.
  LsdPipeline mapping_;
  LsdRelocalization relocalization_;
  MotionCheck motion_check_;
  int implausible_frames_ = 0;  ///< In a row.
  bool has_pose_ = false;       ///< The last frame.
  SE3 last_pose_;               ///< world_from_camera
};

LsdSlam::State::State(const LsdOptions& options, const LsdSensor& sensor, const SlamContext& context)
    : options_(options),
      sensor_(sensor),
      frames_(sensor, options.levels, context.pool),
      check_(options.frame_check),
      start_(options_, sensor_, frames_, context.pool),
      convergence_(two_view_options(options_), sensor_.camera, context.pool),
      search_(options_, sensor_.camera),
      mapping_(options_, sensor_, frames_, context),
      relocalization_(options_, mapping_.settled().graph(),
                      [this](std::int64_t id) { return mapping_.settled().restored_keyframe(id).current(); }),
      motion_check_(sensor.is_metric() ? options.max_acceleration : 0.0) {}

/// One frame, as in figure 3 of Engel et al. 2014: tracked on the newest keyframe, it refines this one's depths or
/// becomes the next keyframe, which is connected with those around it; both beside the tracking of the next frames.
/// Without a map it begins one.
SlamUpdate LsdSlam::State::process(const Frame& frame) {
  Stopwatch whole;
  SlamUpdate update;
  SharedFrame undistorted_frame;
  std::optional<Followed> followed;
  update.index = frame.index;
  update.stamp = frame.stamp;
  update.world_from_body = last_pose_;
  mapping_.take_results({number_++, frame.stamp}, motion_, update);
  if (is_usable(frame, update)) {
    Stopwatch stage;
    undistorted_frame = std::make_shared<const LsdFrame>(frames_.make(frame));
    update.times.push_back({"image", stage.lap_ms()});
    if (mapping_.has_keyframe() && !(motion_.lost && motion_.lost_frames > options_.lost_frames))
      followed = follow(undistorted_frame, update);
    else
      start(*undistorted_frame, update);
  }
  const bool is_plausible = check_motion(update);
  if (followed)
    mapping_.map(undistorted_frame, followed->alignment, followed->is_sure && is_plausible, motion_, update);
  has_pose_ = update.state != SlamState::initializing && update.state != SlamState::lost;
  last_pose_ = update.world_from_body;
  update.world_from_body = update.world_from_body * sensor_.camera_from_left();
  update.milliseconds = whole.lap_ms();
  return update;
}

/// Whether mapping may use the frame. A single jump takes three frames, there and back; what goes on is the camera's
/// own motion, and without new depths it would be lost.
bool LsdSlam::State::check_motion(SlamUpdate& update) {
  constexpr int frames_of_jump = 3;
  motion_check_.follow(std::exchange(motion_.map_moved, SE3()));
  // Else the camera would seem to stop, and then to jump.
  const bool is_repeated = update.state == SlamState::weak && update.reason == SlamReason::repeated_frame;
  if (!is_repeated) motion_check_.check(update);
  const bool is_implausible = update.reason == SlamReason::implausible_motion;
  implausible_frames_ = is_implausible ? implausible_frames_ + 1 : 0;
  return implausible_frames_ == 0 || implausible_frames_ > frames_of_jump;
}

bool LsdSlam::State::is_usable(const Frame& frame, SlamUpdate& update) {
  const FrameCheckResult checked = check_.check(frame.image.view(), frame.stamp);
  update.reason = reason_of(checked.reason);
  update.detail = checked.detail;
  if (checked.useful() || checked.reason == OdometryReason::blurred) return true;
  update.state = mapping_.has_keyframe() ? SlamState::lost : SlamState::initializing;
  if (frame.image.empty()) update.reason = SlamReason::no_data;
  const bool shows_the_same = checked.difference >= 0.0;  // not measured where the stamp goes back
  if (checked.reason != OdometryReason::repeated_frame)
    on_unusable_frame();
  else if (has_pose_ && shows_the_same)
    repeat_pose(frame, update);
  return false;
}

/// The camera may have moved on, which the same image does not say.
void LsdSlam::State::repeat_pose(const Frame& frame, SlamUpdate& update) {
  const SE3& pose = motion_.camera_from_keyframe;
  mapping_.place({frame.index, frame.stamp, mapping_.current().id(), pose.inverse()});
  update.state = SlamState::weak;
  update.world_from_body = mapping_.pose_of(pose);
}

/// The camera moves on unseen. That alone is no reason for a new submap: it may be covered for long.
void LsdSlam::State::on_unusable_frame() {
  motion_.lost = mapping_.has_keyframe();
  motion_.lost_frames = std::min(motion_.lost_frames + 1, options_.lost_frames);
  relocalization_.reset();
  convergence_.interrupt();
}

void LsdSlam::State::start(const LsdFrame& frame, SlamUpdate& update) {
  update.state = mapping_.has_keyframe() ? SlamState::lost : SlamState::initializing;
  if (mapping_.has_keyframe() && (relocalize(frame, false, update) || relocalization_.is_unconfirmed())) return;
  const auto camera_from_keyframe = start_.take(frame, mapping_.idle(motion_, update), search_, update);
  if (!camera_from_keyframe) return;
  mapping_.on_change(true);
  if (options_.start == "random" && !sensor_.is_metric()) convergence_.begin(mapping_.current().id());
  if (update.state != SlamState::lost) doubt(update);
  update.world_from_body = mapping_.pose_of(*camera_from_keyframe);
  motion_ = {};
  motion_.camera_from_keyframe = *camera_from_keyframe;
  motion_.stamp = update.stamp;
  relocalization_.reset();
}

void LsdSlam::State::check_convergence(const LsdFrame& frame, SlamUpdate& update) {
  const std::int64_t keyframe = mapping_.current().id();
  if (!convergence_.take(frame, mapping_.current())) return;
  update.events.push_back({"converged",
                           fmt::format("by keyframe {}: depths that began at random differ by {:.0f} % from those of "
                                       "two views",
                                       keyframe, 100.0 * convergence_.difference()),
                           keyframe});
}

/// Says what is not known yet: where a submap lies, and whether random depths have become true ones.
void LsdSlam::State::doubt(SlamUpdate& update) const {
  mapping_.doubt(update);
  if (update.state == SlamState::weak || !convergence_.is_doubtful(mapping_.current().id())) return;
  update.state = SlamState::weak;
  update.reason = SlamReason::unconfirmed;
  update.detail = "depths that began at random have not converged yet";
  if (convergence_.difference() > 0.0)
    update.detail += fmt::format(": {:.0f} % off those of two views; start=two_views begins with these",
                                 100.0 * convergence_.difference());
}

/// What is in doubt is tried again with all that mapping knows by now.
JudgedAlignment LsdSlam::State::track(const LsdFrame& frame, SlamUpdate& update) {
  Stopwatch stage;
  const bool limits_steps = sensor_.is_metric() && options_.max_acceleration > 0.0;
  const auto try_current = [&] {
    const double max_step = limits_steps ? motion_.step_until(frame.stamp, options_.max_acceleration)
                                         : std::numeric_limits<double>::infinity();
    return search_.track(mapping_.current(), frame.pyramid,
                         {motion_.camera_from_keyframe, motion_.velocity, 0, max_step});
  };
  JudgedAlignment tracked = try_current();
  if (tracked.verdict.grade != PoseGrade::tracking && mapping_.is_busy()) {
    mapping_.idle(motion_, update);
    tracked = try_current();
  }
  update.times.push_back({"track", stage.lap_ms()});
  return tracked;
}

/// What mapping gets of a frame that was tracked.
std::optional<LsdSlam::State::Followed> LsdSlam::State::follow(const SharedFrame& frame, SlamUpdate& update) {
  if (motion_.lost) {
    relocalize(*frame, false, update);
    return std::nullopt;
  }
  const auto [tracked, verdict, jump_deg] = track(*frame, update);
  motion_.weak_frames = verdict.grade == PoseGrade::weak ? motion_.weak_frames + 1 : 0;
  if (verdict.grade == PoseGrade::lost || motion_.weak_frames > options_.lost_frames) {
    on_loss(*frame, verdict, update);
    return std::nullopt;
  }
  update.state = SlamState::tracking;
  check_convergence(*frame, update);
  doubt(update);
  accept(*frame, tracked, update);
  update.covariance = mapping_.covariance_of(tracked, update.world_from_body);
  const bool is_sure = verdict.grade != PoseGrade::weak;
  if (!is_sure) {
    update.state = SlamState::weak;
    update.reason = verdict.reason;
    update.detail = verdict.detail;
  }
  return Followed{tracked, is_sure};
}

void LsdSlam::State::accept(const LsdFrame& frame, const ImageAlignment& tracked, SlamUpdate& update) {
  const SE3& pose = tracked.image_from_reference;
  motion_.accept(frame.stamp, pose);
  search_.remember(frame.pyramid);
  update.score = tracked.inlier_share;
  update.used = tracked.points;
  update.world_from_body = mapping_.pose_of(pose);
}

void LsdSlam::State::on_loss(const LsdFrame& frame, const PoseVerdict& verdict, SlamUpdate& update) {
  update.reason = verdict.reason;
  update.detail = verdict.detail;
  motion_.lost = true;
  motion_.weak_frames = 0;
  convergence_.interrupt();
  relocalize(frame, true, update);
}

/// `was_tried`: on the current keyframe.
bool LsdSlam::State::relocalize(const LsdFrame& frame, bool was_tried, SlamUpdate& update) {
  LsdMapping& mapping = mapping_.idle(motion_, update);
  const ExpectedMotion last{motion_.camera_from_keyframe, motion_.velocity, motion_.lost_frames};
  ++motion_.lost_frames;
  auto found = relocalization_.take(
      frame, mapping_.current(), last, search_, was_tried, [&] { return mapping.words_of(frame); }, update);
  if (!found) return false;
  if (found->keyframe) mapping.return_to(found->id, update);
  const SE3& pose = found->tracked.alignment.image_from_reference;
  for (const PlacedFrame& earlier : found->earlier) mapping.add_frame(earlier);
  mapping.add_frame({frame.index, frame.stamp, found->id, pose.inverse()});
  mapping_.on_change(false);
  motion_.lost = false;
  motion_.camera_from_keyframe = found->last_pose;
  accept(frame, found->tracked.alignment, update);
  SlamUpdate doubted;
  doubted.state = SlamState::tracking;
  doubt(doubted);
  update.state = SlamState::relocalized;
  update.reason = doubted.reason;
  update.detail = doubted.detail;
  update.events.push_back({"relocalized", fmt::format("in keyframe {}", found->id), found->id});
  start_.reset();
  return true;
}

std::vector<SlamEvent> LsdSlam::State::finish() {
  SlamUpdate update;
  mapping_.idle(motion_, update).finish(update);
  return std::move(update.events);
}

Trajectory LsdSlam::State::trajectory() {
  Trajectory trajectory = mapping_.settled().graph().trajectory();
  for (StampedPose& pose : trajectory) pose.world_from_body = pose.world_from_body * sensor_.camera_from_left();
  return trajectory;
}

LsdSlam::LsdSlam(const LsdOptions& options, const LsdSensor& sensor, const SlamContext& context)
    : options_(options),
      sensor_(sensor),
      context_(context),
      state_(std::make_unique<State>(options, sensor, context)) {}
LsdSlam::~LsdSlam() = default;
SlamUpdate LsdSlam::process(const Frame& frame) { return state_->process(frame); }
std::vector<SlamEvent> LsdSlam::finish() { return state_->finish(); }
Trajectory LsdSlam::trajectory() const { return state_->trajectory(); }
std::shared_ptr<const Map> LsdSlam::snapshot() const { return state_->snapshot(); }
MapMemory LsdSlam::map_memory() const { return state_->map_memory(); }
std::int64_t LsdSlam::dropped_frames() const { return state_->dropped_frames(); }
void LsdSlam::reset() { state_ = std::make_unique<State>(options_, sensor_, context_); }

}  // namespace rastro
