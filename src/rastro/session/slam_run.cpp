// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/slam_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/memory.h"
#include "rastro/base/stopwatch.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/odometry/scale.h"
#include "rastro/sensor/stamp_text.h"
#include "rastro/session/frame_reader.h"
#include "rastro/session/run_loop.h"
#include "rastro/session/slam_stats.h"
#include "rastro/session/trajectory_text.h"
#include "rastro/session/watched_input.h"
#include "rastro/slam/calibration_error.h"

namespace rastro {
namespace {

constexpr double covariance_step_m = 2.0;
constexpr const char* online_poses =
    "world_from_body of every frame as first estimated; meters, or arbitrary units if result.json says so";
constexpr const char* covariance_header =
    "# covariance of world_from_body as first estimated: translation x y z (m), rotation x y z (rad), in the world's "
    "axes; "
    "upper triangle, row by row\n# stamp, then 21 numbers\n";

std::string covariance_line(TimeNs stamp, const Matrix6d& covariance) {
  std::string line = seconds_text(stamp);
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) line += fmt::format(" {:.6g}", covariance(row, column));
  return line + "\n";
}

GrayImage copy_of(GrayView view) {
  GrayImage image(view.width, view.height);
  for (int y = 0; y < view.height; ++y) std::copy_n(view.row(y), view.width, image.row(y));
  return image;
}

/// Of the camera that the run uses; 0 without one.
double calibration_error_of(const SourceInfo& info) {
  return info.cameras.empty() || !info.cameras.front().camera ? 0.0 : info.cameras.front().calibration_error;
}

class Runner {
 public:
  explicit Runner(const SlamRun& run)
      : run_(run),
        reader_(*run.source, run.folder),
        input_(run.source->info(), run.folder),
        calibration_error_(calibration_error_of(run.source->info())) {
    if (run.live) run.live->set_folder(run.folder);
    if (!run.folder) return;
    stats_.emplace(run.folder->file("stats.csv"));
    online_.emplace(run.folder->file("trajectory_online.txt")).append(tum_header(online_poses));
  }

  SlamRunEnd run_to_the_end() {
    RunLoopEnd loop = run_loop(reader_, run_.live, run_.stop, [this](Frame& frame) { process(frame); });
    if (run_.max_memory_bytes > 0) return_freed_memory();
    // A method that failed still has a trajectory and a map.
    run_guarded(loop, [this] { finish(); });
    run_guarded(loop, [this] { end_.trajectory = run_.method->trajectory(); });
    run_guarded(loop, [this] { end_.places = run_.method->places(); });
    run_guarded(loop, [this] { take_map(); });
    end_.failure = loop.failure;
    end_.result.interrupted = loop.interrupted;
    end_.result.ended = loop.ended;
    sum_up();
    return std::move(end_);
  }

 private:
  void process(Frame& frame) {
    if (run_.mask_of) frame.mask = copy_of(run_.mask_of(frame));
    Stopwatch watch;
    SlamUpdate update = run_.method->process(frame);
    if (update.covariance && calibration_error_ > 0.0)
      update.covariance = with_calibration_error(
          *update.covariance, run_.initial_pose.inverse() * update.world_from_body, calibration_error_);
    update.milliseconds = watch.lap_ms();
    if (run_.live) run_.live->note_pose();
    count(update);
    note_covariance(update);
    input_.add(frame);
    if (run_.folder) write(update);
    if (run_.progress)
      run_.progress(
          {end_.result.frames + reader_.skipped(), run_.frames_asked, end_.result.loops_closed, &update, &frame});
    return_what_was_freed();
    keep_below_ceiling(frame.index);
  }

  /// Each frame and each copy of the map leaves holes between what stays, and the next one takes others: without end,
  /// so that memory would grow where the map does not. They are given back now and then. Not with every frame, which
  /// would have their pages zeroed again: with that, tracking took twice as long.
  void return_what_was_freed() {
    constexpr double least_mb = 96.0, growth = 1.02;
    constexpr int every_frames = 25;
    if (++frames_since_trim_ < every_frames) return;
    frames_since_trim_ = 0;
    if (resident_memory_mb() < std::max(least_mb, growth * trimmed_mb_)) return;
    return_freed_memory();
    trimmed_mb_ = resident_memory_mb();
  }

  /// What was freed counts as long as the system has not got it back. It gets it before the ceiling is reached: the
  /// next frame may take 8 MB and pass it.
  void keep_below_ceiling(std::int64_t frame) const {
    if (run_.max_memory_bytes == 0) return;
    constexpr double near = 0.92;
    const double most_mb = 1e-6 * static_cast<double>(run_.max_memory_bytes);
    if (resident_memory_mb() <= near * most_mb) return;
    return_freed_memory();
    if (resident_memory_mb() <= most_mb) return;
    throw Error(fmt::format("the memory limit of {:.0f} MB is exhausted", most_mb), fmt::format("frame {}", frame),
                "raise --max-memory; the results so far are kept");
  }

  void finish() {
    Stopwatch watch;
    const std::vector<SlamEvent> events = run_.method->finish();
    const double milliseconds = watch.lap_ms();
    add_time("finish", milliseconds);
    end_.result.timing.method_seconds += milliseconds / 1e3;
    note(last_index_, events);
  }

  void take_map() {
    end_.result.memory.map = run_.method->map_memory();
    end_.map = run_.method->snapshot();
    if (!run_.map_file || !end_.map) return;
    Stopwatch watch;
    name_recording();
    run_.map_file->finish(*end_.map);
    add_time("map_file", watch.lap_ms());
  }

  /// Methods do not know where their frames come from.
  void name_recording() {
    if (end_.map->sessions.empty() || !end_.map->sessions.back().recording.empty()) return;
    auto named = std::make_shared<Map>(*end_.map);
    named->sessions.back().recording = run_.source->info().path;
    end_.map = std::move(named);
  }

  void count(const SlamUpdate& update) {
    SlamResult& result = end_.result;
    if (result.frames++ == 0) first_stamp_ = last_stamp_ = update.stamp;
    last_stamp_ = std::max(last_stamp_, update.stamp);
    last_index_ = update.index;
    std::int64_t* const by_state[] = {&result.states.initializing, &result.states.tracking, &result.states.weak,
                                      &result.states.lost, &result.states.relocalized};
    ++*by_state[static_cast<std::size_t>(update.state)];
    const bool has_pose = update.state != SlamState::initializing && update.state != SlamState::lost;
    if (has_pose && !result.seconds_to_first_pose)
      result.seconds_to_first_pose = to_seconds(update.stamp - first_stamp_);
    if (update.reason != SlamReason::none) ++result.reasons[name_of(update.reason)];
    result.timing.frames.add(update.milliseconds);
    result.timing.method_seconds += update.milliseconds / 1e3;
    for (const StageTime& time : update.times) add_time(time.stage, time.milliseconds);
    note(update.index, update.events);
  }

  void add_time(const std::string& stage, double milliseconds) {
    std::vector<SlamStage>& stages = end_.result.timing.stages;
    auto found = std::find_if(stages.begin(), stages.end(), [&](const SlamStage& each) { return each.name == stage; });
    if (found == stages.end()) found = stages.insert(stages.end(), SlamStage{stage, {}});
    found->times.add(milliseconds);
  }

  void note(std::int64_t index, const std::vector<SlamEvent>& events) {
    for (const SlamEvent& event : events) {
      end_.result.loops_closed += event.kind == "loop_closed" ? 1 : 0;
      if (event.kind == "method") end_.result.method.choice = event.detail;
      if (run_.folder) run_.folder->add_event(index, event.kind, event.detail);
    }
  }

  void note_covariance(const SlamUpdate& update) {
    if (!update.covariance || update.state == SlamState::initializing) return;
    const Eigen::Vector2d position = update.world_from_body.translation().head<2>();
    if (!end_.position_covariances.empty() &&
        (position - end_.position_covariances.back().position).norm() < covariance_step_m)
      return;
    end_.position_covariances.push_back({position, update.covariance->topLeftCorner<2, 2>()});
  }

  void write(const SlamUpdate& update) {
    stats_->add(update);
    if (update.state != SlamState::initializing) online_->append(tum_line({update.stamp, update.world_from_body}));
    if (update.covariance) {
      if (!covariances_) {
        covariances_.emplace(run_.folder->file("covariance_online.txt"));
        covariances_->append(covariance_header);
      }
      covariances_->append(covariance_line(update.stamp, *update.covariance));
    }
    if (update.state == last_state_ && update.reason == last_reason_) return;
    last_state_ = update.state;
    last_reason_ = update.reason;
    const std::string detail = update.detail.empty() ? "" : ": " + update.detail;
    run_.folder->add_event(update.index, name_of(update.state), name_of(update.reason) + detail);
  }

  void sum_up() {
    SlamResult& result = end_.result;
    end_.first_skip = reader_.first_skip();
    result.skipped_frames = reader_.skipped();
    result.warnings = input_.warnings();
    result.timing.dropped_frames = run_.method->dropped_frames();
    if (run_.live) result.timing.live = run_.live->statistics();
    const std::int64_t dropped = result.timing.live ? result.timing.live->dropped : 0;
    const std::int64_t asked = run_.frames_asked.value_or(result.frames + result.skipped_frames + dropped);
    const double posed = static_cast<double>(end_.trajectory.size());
    result.coverage = asked > 0 ? 100.0 * posed / static_cast<double>(asked) : 0.0;
    const auto apart = result.reasons.find(name_of(SlamReason::apart));  // where they are was not known
    const double tracked = static_cast<double>(result.states.tracking + result.states.weak + result.states.relocalized -
                                               (apart == result.reasons.end() ? 0 : apart->second));
    result.recall = asked > 0 ? 100.0 * tracked / static_cast<double>(asked) : 0.0;
    result.path_length = path_length(end_.trajectory);
    result.timing.recording_seconds = to_seconds(last_stamp_ - first_stamp_);
    result.memory.peak_mb = peak_resident_memory_mb();
    if (!end_.map) return;
    count(*end_.map);
  }

  void count(const Map& map) {
    SlamResult& result = end_.result;
    result.keyframes = static_cast<std::int64_t>(map.keyframes.size());
    const auto landmarks = map.layer<LandmarkLayer>();
    result.landmarks = landmarks ? static_cast<std::int64_t>(landmarks->landmarks.size()) : 0;
    std::set<int> submaps;
    for (const Keyframe& keyframe : map.keyframes) submaps.insert(keyframe.submap);
    result.submaps = static_cast<std::int64_t>(submaps.size());
    if (!map.sessions.empty()) result.scale = scale_of(map);
  }

  const SlamRun& run_;
  FrameReader reader_;
  WatchedInput input_;
  double calibration_error_;
  std::optional<SlamStats> stats_;
  std::optional<AppendFile> online_, covariances_;
  SlamRunEnd end_;
  std::int64_t last_index_ = -1;
  double trimmed_mb_ = 0.0;  ///< Resident after the last return_freed_memory().
  int frames_since_trim_ = 0;
  TimeNs first_stamp_ = 0, last_stamp_ = 0;
  SlamState last_state_ = SlamState::initializing;
  SlamReason last_reason_ = SlamReason::none;
};

}  // namespace

SlamRunEnd slam_run(const SlamRun& run) { return Runner(run).run_to_the_end(); }

}  // namespace rastro
