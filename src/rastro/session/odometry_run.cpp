// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/odometry_run.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/memory.h"
#include "rastro/session/frame_reader.h"
#include "rastro/session/live_statistics_json.h"
#include "rastro/session/run_loop.h"
#include "rastro/session/time_histogram.h"
#include "rastro/session/trajectory_text.h"
#include "rastro/session/watched_input.h"

namespace rastro {
namespace {

constexpr const char* online_poses =
    "world_from_camera of every frame as first estimated; world: the first camera; scale: relative";

class Runner {
 public:
  explicit Runner(const OdometryRun& run)
      : run_(run), reader_(*run.source, run.folder), input_(run.source->info(), run.folder) {
    if (run.live) run.live->set_folder(run.folder);
    if (run.folder) online_.emplace(run.folder->file("trajectory_online.txt")).append(tum_header(online_poses));
  }

  OdometryRunEnd run_to_the_end() {
    const RunLoopEnd loop = run_loop(reader_, run_.live, run_.stop, [this](const Frame& frame) { process(frame); });
    end_.failure = loop.failure;
    end_.result.interrupted = loop.interrupted;
    end_.result.ended = loop.ended;
    sum_up();
    return std::move(end_);
  }

 private:
  void process(const Frame& frame) {
    const OdometryUpdate update = run_.method->process(frame);
    if (run_.live) run_.live->note_pose();
    times_.add(update.milliseconds);
    input_.add(frame);
    count(update);
    if (run_.watch) run_.watch(frame, update);
    if (run_.folder) write(update);
    if (run_.progress) run_.progress({end_.result.frames + reader_.skipped(), run_.frames_asked, &update});
  }

  void count(const OdometryUpdate& update) {
    OdometryResult& result = end_.result;
    ++result.frames;
    result.unused_frames += update.used ? 0 : 1;
    std::int64_t* const by_state[] = {&result.initializing, &result.tracking, &result.weak, &result.lost};
    ++*by_state[static_cast<std::size_t>(update.state)];
    if (update.reason != OdometryReason::none) ++result.reasons[name_of(update.reason)];
  }

  void write(const OdometryUpdate& update) {
    online_->append(tum_line({update.stamp, update.world_from_camera}));
    run_.folder->add_stats(update);
    if (update.state == last_state_ && update.reason == last_reason_) return;
    last_state_ = update.state;
    last_reason_ = update.reason;
    const std::string detail = update.detail.empty() ? "" : ": " + update.detail;
    run_.folder->add_event(update.index, name_of(update.state), name_of(update.reason) + detail);
  }

  void sum_up() {
    OdometryResult& result = end_.result;
    end_.trajectory = run_.method->trajectory();
    if (result.tracking + result.weak == 0) end_.trajectory.clear();  // nothing but poses of before the initialization
    end_.first_skip = reader_.first_skip();
    result.skipped_frames = reader_.skipped();
    result.warnings = input_.warnings();
    if (run_.live) result.live = run_.live->statistics();
    const std::int64_t dropped = result.live ? result.live->dropped : 0;
    const std::int64_t asked = run_.frames_asked.value_or(result.frames + result.skipped_frames + dropped);
    const double posed = static_cast<double>(end_.trajectory.size());
    result.coverage = asked > 0 ? 100.0 * posed / static_cast<double>(asked) : 0.0;
    result.ms_per_frame_mean = times_.mean_ms();
    result.ms_per_frame_p95 = times_.percentile_ms(0.95);
    result.peak_memory_mb = peak_resident_memory_mb();
  }

  const OdometryRun& run_;
  FrameReader reader_;
  WatchedInput input_;
  std::optional<AppendFile> online_;
  OdometryRunEnd end_;
  TimeHistogram times_;
  OdometryState last_state_ = OdometryState::initializing;
  OdometryReason last_reason_ = OdometryReason::none;
};

}  // namespace

OdometryRunEnd odometry_run(const OdometryRun& run) { return Runner(run).run_to_the_end(); }

std::string to_json(const OdometryResult& result) {
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
  nlohmann::ordered_json json;
  json["method"] = result.method.name;
  if (!result.method.choice.empty()) json["method_choice"] = result.method.choice;
  json["frames"] = result.frames;
  json["skipped_frames"] = result.skipped_frames;
  json["coverage"] = rounded(result.coverage);
  json["tracking"] = result.tracking;
  json["weak"] = result.weak;
  json["lost"] = result.lost;
  json["initializing"] = result.initializing;
  json["unused_frames"] = result.unused_frames;
  json["reasons"] = result.reasons;
  json["warnings"] = json_of(result.warnings);
  json["path_length"] = rounded(result.path_length);
  json["scale"] = result.scale;
  json["ms_per_frame_mean"] = rounded(result.ms_per_frame_mean);
  json["ms_per_frame_p95"] = rounded(result.ms_per_frame_p95);
  json["peak_memory_mb"] = rounded(result.peak_memory_mb);
  if (result.live) json["live"] = json_of(*result.live);
  json["result_sha256"] = result.result_sha256;
  json["interrupted"] = result.interrupted;
  json["ended"] = result.ended;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace rastro
