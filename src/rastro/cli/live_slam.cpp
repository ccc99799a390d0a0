// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/memory.h"
#include "rastro/cli/loss_advice.h"
#include "rastro/map/file/map_file.h"

namespace rastro::cli {
namespace {

constexpr double most_share_of_memory = 0.7;  // of a run's limit, which a copy of the map counts for as well

bool has_pose(SlamState state) { return state != SlamState::initializing && state != SlamState::lost; }

LiveFrame live_frame(const SlamUpdate& update) {
  LiveFrame live;
  live.index = update.index;
  live.stamp_s = to_seconds(update.stamp);
  live.state = scene_state_of(name_of(update.state));
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

/// The states in the order of ObservationState.
std::vector<std::string> observation_state_names() {
  std::vector<std::string> names;
  for (const auto state : {ObservationState::unmatched, ObservationState::matched, ObservationState::outlier,
                           ObservationState::inlier, ObservationState::new_landmark})
    names.emplace_back(name_of(state));
  return names;
}

LiveFeatures live_features(const std::vector<FeatureObservation>& observations) {
  LiveFeatures features;
  features.state_names = observation_state_names();
  for (const FeatureObservation& feature : observations) {
    features.pixels.insert(features.pixels.end(), {feature.pixel.x(), feature.pixel.y()});
    features.states.push_back(static_cast<std::uint8_t>(feature.state));
  }
  return features;
}

std::vector<LiveCommand> commands_of_mapping() {
  return {LiveCommand::mapping_on, LiveCommand::mapping_off, LiveCommand::save, LiveCommand::reset};
}

std::filesystem::path next_free_map(const std::filesystem::path& folder) {
  for (int number = 1;; ++number) {
    auto file = folder / fmt::format("map_{:04}.rastro", number);
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return file;
  }
}

}  // namespace

LiveSlam::LiveSlam(const ServerFlags& flags, const LiveHello& run, Slam& method, bool mapping,
                   std::filesystem::path folder, std::size_t max_memory_bytes)
    : method_(method),
      folder_(std::move(folder)),
      most_mb_(max_memory_bytes > 0 ? most_share_of_memory * 1e-6 * static_cast<double>(max_memory_bytes)
                                    : std::numeric_limits<double>::infinity()),
      sink_(
          flags, run, mapping ? commands_of_mapping() : std::vector<LiveCommand>{},
          [this](LiveCommand command) { obey(command); },
          [this](const Map& map, const SeenImages& seen) { return places_.of(map, seen); }) {
  if (!mapping) return;
  sink_.set_mapping(true);
  sink_.say("");
}

void LiveSlam::show(const SlamProgress& progress) {
  if (progress.last != nullptr && sink_.is_watched()) {
    LiveFrame live = live_frame(*progress.last);
    live.done = progress.done;
    sink_.show(std::move(live));
    places_.note(*progress.last);
    if (progress.frame != nullptr) show_image(*progress.frame);
    show_map();
  }
  sink_.obey_pages();
}

void LiveSlam::show_image(const Frame& frame) {
  if ((frame.image.empty() && frame.color.empty()) || !sink_.view().wants_image()) return;
  SeenImage seen;
  seen.frame.index = frame.index;
  seen.frame.stamp = frame.stamp;
  seen.frame.image = frame.image;
  seen.frame.color = frame.color;
  seen.features = live_features(method_.observations());
  sink_.view().show(std::move(seen));
}

void LiveSlam::show_map() {
  if (!sink_.view().wants_map(snapshot_ms_) || resident_memory_mb() > most_mb_) return;
  Stopwatch watch;
  auto map = method_.snapshot();
  snapshot_ms_ = watch.lap_ms();
  if (map && !map->keyframes.empty()) sink_.view().show(std::move(map));
}

void LiveSlam::obey(LiveCommand command) {
  if (!sink_.mapping()) return;
  if (command == LiveCommand::save) save();
  if (command == LiveCommand::reset) reset();
  if (command == LiveCommand::mapping_on || command == LiveCommand::mapping_off)
    set_mapping(command == LiveCommand::mapping_on);
}

bool LiveSlam::save() {
  const auto map = method_.snapshot();
  if (!map || map->keyframes.empty()) {
    sink_.say("there is no map yet");
    return false;
  }
  const std::filesystem::path file = next_free_map(folder_);
  try {
    save_map(*map, file);
  } catch (const Error& error) {
    sink_.say(std::string("the map was not saved: ") + error.what());
    return false;
  }
  sink_.say(fmt::format("the map so far is in {}", file.string()));
  return true;
}

/// The map so far is kept as a file: a method forgets it.
void LiveSlam::reset() {
  const auto map = method_.snapshot();
  const bool has_map = map && !map->keyframes.empty();
  if (has_map && !save()) return;
  method_.reset();
  places_.forget();
  sink_.view().forget_map();
  sink_.count_reset();
  sink_.set_mapping(true);
  sink_.say(has_map ? "a new map begins; the one before is saved" : "a new map begins");
}

void LiveSlam::set_mapping(bool on) {
  if (!method_.set_mapping(on)) return sink_.say("this method cannot localize without mapping");
  sink_.set_mapping(on);
  sink_.say(on ? "" : "localizes only: the map does not change");
}

void LiveSlam::finish(const SlamRunEnd& end) {
  sink_.finish(fmt::format("{} frames, {:.1f} % with a pose, {} loop closures", end.result.frames, end.result.coverage,
                           end.result.loops_closed));
  if (sink_.is_watched() && end.map && !end.map->keyframes.empty()) sink_.view().finish(end.map);
}

}  // namespace rastro::cli
