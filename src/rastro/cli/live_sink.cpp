// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "rastro/base/memory.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/loss_advice.h"

namespace rastro::cli {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t most_points = 300'000;  // of a scene that is made anew all the time
constexpr double most_share_of_memory = 0.7;  // of a run's limit, which a copy of the map counts for as well

std::size_t scene_state_of(SlamState state) {
  const auto& names = scene_state_names();
  const auto found = std::find(names.begin(), names.end(), name_of(state));
  return static_cast<std::size_t>(found - names.begin());
}

std::uint8_t live_state_of(ObservationState state) {
  const auto& names = live_feature_state_names();
  const auto found = std::find(names.begin(), names.end(), name_of(state));
  return static_cast<std::uint8_t>(found - names.begin());
}

bool has_pose(SlamState state) { return state != SlamState::initializing && state != SlamState::lost; }

LiveFrame live_frame(const SlamUpdate& update) {
  LiveFrame live;
  live.index = update.index;
  live.stamp_s = to_seconds(update.stamp);
  live.state = scene_state_of(update.state);
  if (update.reason != SlamReason::none) live.reason = name_of(update.reason);
  live.detail = update.detail;
  if (update.state == SlamState::weak || update.state == SlamState::lost) live.advice = advice_for(update.reason);
  if (has_pose(update.state)) live.world_from_body = update.world_from_body;
  if (update.covariance) live.sigma = std::sqrt(update.covariance->topLeftCorner<3, 3>().trace());
  live.used = update.used;
  live.score = update.score;
  live.milliseconds = update.milliseconds;
  for (const StageTime& time : update.times) live.stages.emplace_back(time.stage, time.milliseconds);
  for (const SlamEvent& event : update.events) live.events.emplace_back(event.kind, event.detail);
  return live;
}

ViewServerOptions with_token(ViewServerOptions options) {
  if (options.token.empty()) options.token = random_token();
  return options;
}

ViewSceneOptions live_scene_options() {
  ViewSceneOptions options;
  options.max_points = most_points;
  return options;
}

}  // namespace

LiveSink::LiveSink(const ServerFlags& flags, const LiveHello& run, Slam& method, bool mapping,
                   std::size_t max_memory_bytes)
    : method_(method),
      most_mb_(max_memory_bytes > 0 ? most_share_of_memory * static_cast<double>(max_memory_bytes) / (1024.0 * 1024.0)
                                    : std::numeric_limits<double>::infinity()),
      view_(with_token(server_options(flags)), run, live_scene_options()) {
  if (mapping) status_.mapping = true;
  say("");
  fmt::print(stderr, "view: {}\n", view_.url());
}

void LiveSink::show(const SlamProgress& progress) {
  if (progress.last != nullptr && view_.is_watched()) {
    show_frame(progress);
    show_image(progress);
    show_map();
  }
  if (std::exchange(steps_, false)) status_.paused = true;
  constexpr int most_at_once = 64;  // a page that sends without end does not hold up the run
  for (int k = 0; k < most_at_once; ++k) {
    const auto command = view_.next_command(milliseconds(0));
    if (!command) break;
    obey(*command);
  }
  while (status_.paused && view_.is_watched() && !catch_interrupts().load())
    if (const auto command = view_.next_command(milliseconds(50))) obey(*command);
  if (!status_.paused || view_.is_watched()) return;
  status_.paused = false;  // a page that pauses a run and is closed leaves it to go on
  say("");
}

void LiveSink::show_frame(const SlamProgress& progress) {
  LiveFrame live = live_frame(*progress.last);
  live.done = progress.done;
  live.rate_hz = static_cast<double>(progress.done) / std::max(1e-3, 1e-3 * since_begin_.elapsed_ms());
  live.memory_mb = resident_memory_mb();
  view_.show(live);
}

void LiveSink::show_image(const SlamProgress& progress) {
  if (progress.frame == nullptr || (progress.frame->image.empty() && progress.frame->color.empty())) return;
  if (!view_.wants_image()) return;
  SeenImage seen;
  seen.frame.index = progress.frame->index;
  seen.frame.image = progress.frame->image;
  seen.frame.color = progress.frame->color;
  for (const FeatureObservation& feature : method_.observations()) {
    seen.features.insert(seen.features.end(), {feature.pixel.x(), feature.pixel.y()});
    seen.states.push_back(live_state_of(feature.state));
  }
  view_.show(std::move(seen));
}

void LiveSink::show_map() {
  if (!view_.wants_map(snapshot_ms_) || resident_memory_mb() > most_mb_) return;
  Stopwatch watch;
  auto map = method_.snapshot();
  snapshot_ms_ = watch.lap_ms();
  if (map && !map->keyframes.empty()) view_.show(std::move(map));
}

void LiveSink::obey(LiveCommand command) {
  switch (command) {
    case LiveCommand::pause:
      status_.paused = true;
      return say("paused");
    case LiveCommand::resume:
      status_.paused = false;
      return say("");
    case LiveCommand::step:
      steps_ = std::exchange(status_.paused, false);
      return;
    case LiveCommand::mapping_on:
      return set_mapping(true);
    case LiveCommand::mapping_off:
      return set_mapping(false);
    case LiveCommand::end:
      status_.paused = false;
      say("ends after this frame");
      return interrupt();
  }
}

void LiveSink::set_mapping(bool on) {
  if (!status_.mapping) return;
  if (!method_.set_mapping(on)) return say("this method cannot localize without mapping");
  status_.mapping = on;
  say(on ? "" : "localizes only: the map does not change");
}

void LiveSink::say(const std::string& line) {
  status_.line = line;
  view_.say(status_);
}

void LiveSink::finish(const SlamRunEnd& end) {
  status_.paused = false;
  status_.ended = true;
  say(fmt::format("{} frames, {:.1f} % with a pose, {} loop closures", end.result.frames, end.result.coverage,
                  end.result.loops_closed));
  if (view_.is_watched() && end.map && !end.map->keyframes.empty()) view_.finish(end.map);
}

void LiveSink::wait_until_closed() {
  if (!view_.is_watched() || interrupt_signals() > 0) return;
  std::fflush(stdout);  // it may be a pipe
  fmt::print(stderr, "view: still open; ends when the page is closed, or with Ctrl-C\n");
  while (view_.is_watched() && interrupt_signals() == 0) view_.next_command(milliseconds(100));
}

}  // namespace rastro::cli
