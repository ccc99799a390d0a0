// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace rastro {
namespace {

void add_time(const StageTime& time, std::vector<StageTime>& times) {
  const auto same = std::find_if(times.begin(), times.end(),
                                 [&](const StageTime& each) { return std::string(each.stage) == time.stage; });
  if (same == times.end())
    times.push_back(time);
  else
    same->milliseconds += time.milliseconds;
}

DepthErrorModel errors_of_depth(const LsdSensor& sensor, const LsdOptions& options) {
  if (!sensor.is_metric()) return errors_of_one_camera(options.scale_drift_share);
  return sensor.kind == CameraKind::stereo ? errors_of_pair() : errors_of_depth_camera();
}

}  // namespace

LsdPipeline::LsdPipeline(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames,
                         const SlamContext& context)
    : options_(options),
      is_metric_(sensor.is_metric()),
      archive_(context.archive),
      mapping_pool_(context.pool ? context.pool->threads() : 1, TaskPriority::low),
      mapping_(options, sensor, frames, LsdPools{context.pool, &mapping_pool_}, context),
      uncertainty_(errors_of_depth(sensor, options)),
      pipeline_(mapping_pipeline(context.pipelined, context.live, context.pool)) {}

void LsdPipeline::take_results(const FrameTime& now, LsdMotion& motion, SlamUpdate& update) {
  now_ = now;
  while (auto result = pipeline_.take_ready(now)) take(std::move(*result), motion, update);
}

LsdMapping& LsdPipeline::idle(LsdMotion& motion, SlamUpdate& update) {
  while (auto result = pipeline_.take_next()) take(std::move(*result), motion, update);
  place_waiting();
  return mapping_;
}

const LsdMapping& LsdPipeline::settled() {
  pipeline_.wait();
  place_waiting();
  return mapping_;
}

/// Only while no job runs.
void LsdPipeline::place_waiting() {
  for (const PlacedFrame& frame : waiting_) mapping_.add_frame(frame);
  waiting_.clear();
}

void LsdPipeline::take(Result result, LsdMotion& motion, SlamUpdate& update) {
  const SE3 before = pose_of(motion.camera_from_keyframe);
  if (result.before_from_new) {
    motion.change_keyframe(*result.before_from_new);
    frames_on_current_ = 0;
    is_changing_ = false;
    add_uncertainty(result);
  }
  current_.emplace(std::move(result.current));
  motion.map_moved = pose_of(motion.camera_from_keyframe) * before.inverse() * motion.map_moved;
  memory_ = std::move(result.memory);
  update.events.insert(update.events.end(), result.events.begin(), result.events.end());
  for (const StageTime& time : result.times) add_time(time, update.times);
  // Not by the job: what the archive throws, as on a full disk, would cost all that mapping has.
  if (result.map_to_keep) archive_->keep(std::move(result.map_to_keep));
}

void LsdPipeline::add_uncertainty(const Result& result) {
  const Eigen::Vector3d position = result.current.world_from_keyframe.translation();
  const std::int64_t before = result.frame.keyframe;
  if (result.joint && !uncertainty_.knows(before))
    uncertainty_.join(before, position, result.joint->earlier, result.joint->covariance, result.joint->scale_variance);
  if (uncertainty_.knows(before)) uncertainty_.add(result.current.keyframe.id(), position, result.frame);
}

/// Submaps may also be joined while the camera is found again.
void LsdPipeline::note_joint() {
  const auto joint = mapping_.take_joint();
  if (!joint || current_->submap != 0 || uncertainty_.knows(current().id())) return;
  uncertainty_.join(current().id(), current_->world_from_keyframe.translation(), joint->earlier, joint->covariance,
                    joint->scale_variance);
}

void LsdPipeline::on_change(bool is_new) {
  current_.emplace(mapping_.current());
  memory_ = mapping_.memory();
  frames_on_current_ = 0;
  note_joint();
  if (is_new && current_->submap == 0) uncertainty_.set_known(current().id(), Eigen::Vector3d::Zero());
}

void LsdPipeline::map(std::shared_ptr<const LsdFrame> frame, const ImageAlignment& tracked, bool is_sure,
                      const LsdMotion& motion, const SlamUpdate& update) {
  if (!pipeline_.accepts()) {
    waiting_.push_back({frame->index, frame->stamp, current().id(), tracked.image_from_reference.inverse()});
    return;
  }
  MappingInput input{std::move(frame), current().id(), tracked, MappingInput::Use::place, {}};
  if (is_sure) input.use = MappingInput::Use::refine;
  if (is_sure && knows_scale(tracked) && !is_changing_ && current().is_left_by(tracked)) {
    input.use = MappingInput::Use::keyframe;
    input.depth_from_color = motion.within(input.frame->depth_stamp - input.frame->stamp);
    is_changing_ = true;
  }
  // Frames tracked on the keyframe before are farther from it: on the kitchen, a later change costs a quarter more
  // error. In fast turns, its first depths are all that the next frame has.
  constexpr std::int64_t next_frame = 1;
  const bool is_keyframe = input.use == MappingInput::Use::keyframe;
  const bool is_new = frames_on_current_++ < options_.backend_direct_frames;
  const auto job = [this, input = std::move(input), waiting = std::exchange(waiting_, {}),
                    placed = aligned(tracked, update.world_from_body)] {
    for (const PlacedFrame& earlier : waiting) mapping_.add_frame(earlier);
    SlamUpdate said;
    const auto before_from_new = mapping_.process(input, said);
    return Result{mapping_.current(),    before_from_new,       placed,
                  mapping_.take_joint(), mapping_.memory(),     std::move(said.events),
                  std::move(said.times), mapping_.map_to_keep()};
  };
  pipeline_.submit(job, now_, {is_keyframe || is_new ? next_frame : options_.backend_delay_frames});
}

/// Whether the map may go on from the frame: the scale of what comes into view follows from the motion.
bool LsdPipeline::knows_scale(const ImageAlignment& tracked) const {
  if (is_metric_) return true;
  if (!current().tells_scale(tracked)) return false;
  if (options_.start == "random") return true;
  const double step = scale_variance_of_new(share_of_new(tracked), tracked.motion_error());
  return std::sqrt(current_->scale_error * current_->scale_error + step) <= options_.max_keyframe_scale_error;
}

SE3 LsdPipeline::pose_of(const SE3& camera_from_keyframe) const {
  const Sim3 pose = current_->world_from_keyframe * Sim3(camera_from_keyframe.inverse());
  return {pose.rotation(), pose.translation()};
}

std::optional<Matrix6d> LsdPipeline::covariance_of(const ImageAlignment& tracked, const SE3& world_from_camera) const {
  if (current_->submap != 0 || !uncertainty_.knows(current().id())) return std::nullopt;
  AlignedFrame frame = aligned(tracked, world_from_camera);
  if (current_->scale_error > options_.max_scale_error) frame.scale_error = current_->scale_error;
  return uncertainty_.of_frame(frame);
}

AlignedFrame LsdPipeline::aligned(const ImageAlignment& tracked, const SE3& world_from_camera) const {
  return {current().id(),
          current_->world_from_keyframe.scale(),
          current().mean_inverse_depth(),
          world_from_camera,
          tracked,
          current().attenuation()};
}

void LsdPipeline::doubt(SlamUpdate& update) const {
  const bool is_apart = current_->submap != 0;
  if (!is_apart && current_->scale_error <= options_.max_scale_error) return;
  update.state = SlamState::weak;
  update.reason = is_apart ? SlamReason::apart : SlamReason::uncertain_scale;
  update.detail = is_apart
                      ? fmt::format("in submap {}, not connected to the first yet", current_->submap)
                      : fmt::format("the scale is uncertain by {:.0f} %: too little motion for what came into view",
                                    100.0 * current_->scale_error);
}

}  // namespace rastro
