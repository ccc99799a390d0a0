// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/keyframe_pipeline.h"

#include <utility>

#include "rastro/slam/orb/map/map_export.h"

namespace rastro {
namespace {

constexpr std::size_t observed_frames = 500;  ///< Keep their observations, to be refined with the final map.
constexpr std::size_t refined_at_once = 100;  ///< At least.

constexpr double reserve_mb = 150.0;  ///< For everything except the map.

}  // namespace

KeyframePipeline::KeyframePipeline(OrbSession& session, FrameTracker& tracker, const SlamContext& context)
    : session_(session),
      tracker_(tracker),
      on_finishing_(context.on_finishing),
      adjusting_pool_(context.pool ? context.pool->threads() : 1, TaskPriority::low),
      mapping_pool_(context.pool ? context.pool->threads() : 1, TaskPriority::low),
      local_mapping_(session.options, session.graph, &mapping_pool_, session.stop, session.direct.alignment.get()),
      thinning_(session.options, session.graph, map_budget_bytes(context, reserve_mb)),
      database_(session.graph, standard_vocabulary()),
      loop_closing_(session.options, session.graph, database_),
      mapping_(mapping_pipeline(context.pipelined, context.live, context.pool)),
      adjusting_(mapping_pipeline(context.pipelined, context.live, context.pool)) {}

KeyframePipeline::Result KeyframePipeline::process(const KeyframeInput& keyframe, std::size_t trajectory_bytes) {
  const std::int64_t id = keyframe.frame->data().id;
  Result result;
  result.keyframe = id;
  result.view_of_keyframe = local_mapping_.process(keyframe);
  result.adjusted = local_mapping_.adjusted();
  if (session_.options.loop_closing) {
    result.loop = loop_closing_.process(id);
    if (result.loop) {
      result.events.push_back(result.loop->event());
      if (session_.options.loop_adjust_iterations > 0)
        result.adjustment = std::make_shared<GlobalBundleAdjustment>(session_.graph, session_.graph.keyframe(id).submap,
                                                                     session_.options.pixel_sigma);
      newest_adjustment_ = result.adjustment;
    }
  }
  thinning_.process(trajectory_bytes + local_mapping_.view_bytes(), result.events);
  result.budget = thinning_.budget();
  result.removed = session_.graph.take_removed();
  result.view = view_of(session_.graph, id, session_.view_options());
  return result;
}

HandOverDelay KeyframePipeline::mapping_delay() const {
  return {session_.options.backend_delay_frames, from_seconds(session_.options.backend_delay_s),
          session_.options.keyframe_frames};
}

void KeyframePipeline::insert(std::shared_ptr<const KeyframeInput> keyframe, TimeNs stamp) {
  const std::size_t trajectory_bytes = thinning_.limited() ? session_.trajectory.bytes() : 0;
  auto frames =
      std::make_shared<std::vector<TrackedFrame>>(session_.trajectory.take_observed(observed_frames, refined_at_once));
  const auto job = [this, keyframe = std::move(keyframe), frames = std::move(frames), trajectory_bytes] {
    Result result = process(*keyframe, trajectory_bytes);
    for (TrackedFrame& frame : *frames) refine_frame(frame, session_.graph, session_.options.min_inliers / 2);
    result.refined = std::move(*frames);
    return result;
  };
  mapping_.submit(job, session_.frame_time(stamp), mapping_delay());
}

void KeyframePipeline::insert_now(const KeyframeInput& keyframe) {
  local_mapping_.process(keyframe);
  tracker_.set_view(view_of(session_.graph, keyframe.frame->data().id, session_.view_options()));
}

void KeyframePipeline::take_results(TimeNs stamp, std::vector<SlamEvent>& events) {
  const FrameTime now = session_.frame_time(stamp);
  // A map that does not change refines nothing.
  if (!session_.mapping && session_.frame_number % static_cast<std::int64_t>(refined_at_once) == 0)
    session_.trajectory.take_observed(observed_frames, refined_at_once);
  // A live run may have no room for the job: it waits.
  if (!mapping_.empty() && !mapping_.has_room())
    while (auto result = mapping_.take_ready(now)) take(std::move(*result), events);
  if (mapping_.has_room())
    if (auto adjustment = adjusting_.take_ready(now)) take_adjustment(std::move(*adjustment), stamp);
  while (auto result = mapping_.take_ready(now)) take(std::move(*result), events);
}

void KeyframePipeline::take_all_results(std::vector<SlamEvent>& events) {
  while (auto result = mapping_.take_next()) take(std::move(*result), events);
}

void KeyframePipeline::take(Result result, std::vector<SlamEvent>& events) {
  events.insert(events.end(), result.events.begin(), result.events.end());
  session_.trajectory.put_back(result.refined);
  session_.direct.keyframes.add(result.keyframe, result.view_of_keyframe);
  for (const AdjustedKeyframe& keyframe : result.adjusted)
    session_.uncertainty.contradict(keyframe.id, keyframe.world_from_camera_before, keyframe.world_from_camera);
  if (result.loop) note_loop(*result.loop);
  if (session_.tracking && result.view) tracker_.set_view(result.view);
  for (const std::int64_t keyframe : result.removed) session_.uncertainty.forget(keyframe);
  if (result.adjustment) begin_adjustment(std::move(result.adjustment));
  spend_sparingly(result.budget);
  archive_map();
}

void KeyframePipeline::note_loop(const LoopResult& loop) {
  MapUncertainty& uncertainty = session_.uncertainty;
  if (!loop.merged) return uncertainty.close_loop(loop.matched, loop.keyframe);
  for (const auto& [id, center] : loop.transformed) uncertainty.join(id, loop.stayed, center, loop.new_from_old);
  // Keyframes that tracking added since are in the submap of the loop's.
  if (loop.stayed == loop.keyframe) return;
  for (const auto& [id, center] : uncertainty.after(loop.keyframe))
    uncertainty.join(id, loop.stayed, center, loop.new_from_old);
}

/// Tracking's measures to stay within the budget, as last reported by mapping.
void KeyframePipeline::spend_sparingly(const MapBudget& budget) {
  if (budget.stage() == 0) return;
  session_.spacing = budget.spacing();
  constexpr double a_stage = 0.1;
  session_.keyframe_share = 1.0 - a_stage * budget.stage();
  if (budget.stage() > 1) session_.trajectory.forget_observations();
}

/// An adjustment in flight no longer fits a map that has been corrected since.
void KeyframePipeline::begin_adjustment(std::shared_ptr<GlobalBundleAdjustment> adjustment) {
  cancel_adjustment();
  const OrbSlamOptions& options = session_.options;
  const double delay_s = options.loop_adjust_delay_s * static_cast<double>(adjustment->observations()) / 1e5;
  const HandOverDelay delay{options.backend_delay_frames, from_seconds(delay_s), 20 * options.keyframe_frames};
  adjustment_ = adjustment;
  adjusting_.submit(
      [this, adjustment = std::move(adjustment)] {
        adjustment->run(session_.options.loop_adjust_iterations, session_.stop, &adjusting_pool_);
        return adjustment;
      },
      session_.frame_time(session_.last_stamp), delay);
}

/// Mapping applies the adjusted submap, in order with the keyframes.
void KeyframePipeline::take_adjustment(std::shared_ptr<GlobalBundleAdjustment> adjustment, TimeNs stamp) {
  adjustment_.reset();
  const std::int64_t center = session_.tracking ? tracker_.view()->center : -1;
  mapping_.submit([this, adjustment = std::move(adjustment), center] { return apply(*adjustment, center); },
                  session_.frame_time(stamp), mapping_delay());
}

KeyframePipeline::Result KeyframePipeline::apply(const GlobalBundleAdjustment& adjustment, std::int64_t center) {
  Result result;
  // Another loop corrected the map while this one waited for its turn; it has an adjustment of its own.
  if (newest_adjustment_.lock().get() != &adjustment) return result;
  result.events.push_back({"adjusted", adjustment.detail()});
  adjustment.apply(session_.graph);
  if (session_.graph.has_keyframe(center)) result.view = view_of(session_.graph, center, session_.view_options());
  return result;
}

void KeyframePipeline::cancel_adjustment() {
  if (adjustment_) adjustment_->cancel();
  adjustment_.reset();
  adjusting_.discard();
}

void KeyframePipeline::pause(std::vector<SlamEvent>& events) {
  cancel_adjustment();
  take_all_results(events);
  cancel_adjustment();  // from a loop closed just now
}

void KeyframePipeline::finish(std::vector<SlamEvent>& events) {
  take_all_results(events);
  const bool stopped = session_.stopped();
  if (stopped) {
    cancel_adjustment();
  } else if (auto adjustment = adjusting_.take_next()) {
    take_adjustment(std::move(*adjustment), session_.last_stamp);
    take_all_results(events);
  }
  if (!session_.has_map) return;
  if (session_.mapping && !stopped) adjust_map();
  session_.trajectory.refine(session_.graph, session_.options.min_inliers / 2);
  archive_map();
}

void KeyframePipeline::adjust_map() {
  const OrbSlamOptions& options = session_.options;
  if (options.final_iterations <= 0) return;
  if (session_.graph.keyframe_count() > static_cast<std::size_t>(options.final_keyframes)) return;
  const auto submaps = static_cast<std::size_t>(session_.graph.submap_count());
  for (int submap = 0; submap < session_.graph.submap_count(); ++submap) {
    if (on_finishing_) on_finishing_("bundle adjustment, submap", static_cast<std::size_t>(submap), submaps);
    local_mapping_.adjust_all(submap, options.final_iterations);
  }
}

void KeyframePipeline::archive_map() {
  if (session_.archive != nullptr && session_.mapping && mapping_.empty() && session_.archive->wants_map())
    session_.archive->keep(map_of(session_.graph, session_.trajectory, session_.given, session_.method));
}

}  // namespace rastro
