// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "rastro/base/background.h"
#include "rastro/base/task_pool.h"
#include "rastro/base/time.h"

namespace rastro {

/// When the front end gets results.
enum class HandOver : std::uint8_t {
  /// At a fixed later frame, never earlier; the front end waits for a late result. Every run gives the same bytes, with
  /// a thread beside the front end or without one.
  fixed_delay,
  /// As soon as they are ready, for a live run: the front end never waits, and runs may differ.
  when_ready,
};

/// The front end's current frame: its number, counting all frames, and its stamp.
struct FrameTime {
  std::int64_t number = 0;
  TimeNs stamp = 0;
};

/// The pipeline latency: delay from the frame of a job to the hand-over of its result.
struct HandOverDelay {
  std::int64_t frames = 1;          ///< At least this many frames, and ...
  std::optional<TimeNs> time = {};  ///< ... this much time by the stamps; nullopt: frames alone count.
  /// If stamps stop increasing, this many further frames count instead of the time.
  std::int64_t max_extra_frames = 0;
};

struct PipelineOptions {
  bool own_thread = false;  ///< False: a job runs in submit().
  HandOver hand_over = HandOver::fixed_delay;
  /// With `when_ready`, maximum number of results in flight: a job beyond that is dropped. 0: unlimited.
  std::size_t max_in_flight = 0;
};

/// For mapping beside tracking: on a thread of its own where there are several; live, results are handed over when they
/// are ready, and few keyframes may wait.
PipelineOptions mapping_pipeline(bool pipelined, bool live, const TaskPool* pool);

struct PipelineStatistics {
  std::int64_t jobs = 0;         ///< Accepted.
  std::int64_t handed_over = 0;  ///< Results taken.
  double wait_ms = 0.0;          ///< Time that the front end waited for results.
  std::int64_t postponed = 0;    ///< With `when_ready`: results that were later than with fixed_delay.
  std::int64_t dropped = 0;      ///< With `when_ready`: jobs that were not accepted.
};

/// The order of jobs and the times at which results are handed over, for any type of result. Used by Pipeline.
class PipelineQueue {
 public:
  explicit PipelineQueue(const PipelineOptions& options) : options_(options), background_(options.own_thread) {}

  bool submit(std::function<void()> job, std::shared_ptr<void> result, const FrameTime& now,
              const HandOverDelay& delay);
  bool has_room() const;
  bool accepts();
  /// Null: none to be handed over now.
  std::shared_ptr<void> take_ready(const FrameTime& now);
  /// Null: none in flight.
  std::shared_ptr<void> take_next();
  void discard() { in_flight_.clear(); }
  void wait() const { background_.wait_for_all(); }
  bool empty() const { return in_flight_.empty(); }
  bool settled(const FrameTime& now) const;
  const PipelineStatistics& statistics() const { return statistics_; }

 private:
  struct InFlight {
    std::size_t job = 0;
    std::int64_t handover_frame = 0;           ///< First frame number that may see the result, ...
    std::optional<TimeNs> handover_time = {};  ///< ... the earliest stamp, ...
    std::int64_t last_frame = 0;               ///< ... and the frame from which stamps no longer count.
    std::shared_ptr<void> result;
    bool postponed = false;
  };

  static bool latency_passed(const InFlight& item, const FrameTime& now);
  bool is_ready(InFlight& item, const FrameTime& now);

  PipelineOptions options_;
  PipelineStatistics statistics_;
  std::deque<InFlight> in_flight_;
  InFlight last_;  ///< The job submitted last; its result is not kept here.
  mutable Background background_;
};

/// Runs jobs beside a front end, one after the other in the order of submission, and hands over their results in that
/// order. Only the front end's thread calls it. A job may use data that nothing else accesses while jobs are in flight.
/// An exception of a job is thrown when its result, or a later one, is taken or waited for; no job runs after it.
template <typename Result>
class Pipeline {
 public:
  explicit Pipeline(const PipelineOptions& options) : queue_(options) {}

  /// `now`: the frame that the job belongs to. False: dropped, see PipelineOptions::max_in_flight.
  bool submit(std::function<Result()> job, const FrameTime& now, const HandOverDelay& delay) {
    const auto result = std::make_shared<std::optional<Result>>();
    return queue_.submit([job = std::move(job), result] { result->emplace(job()); }, result, now, delay);
  }
  /// Whether a job submitted now would be accepted. If not, it counts as dropped. For a front end that must know before
  /// it prepares a job.
  bool accepts() { return queue_.accepts(); }
  /// The same, for a job that can wait: it does not count as dropped.
  bool has_room() const { return queue_.has_room(); }
  /// The oldest result, if it is to be handed over by `now`; call again until there is none.
  std::optional<Result> take_ready(const FrameTime& now) { return taken(queue_.take_ready(now)); }
  /// The oldest result, whatever its delay; waits for it. nullopt: none in flight.
  std::optional<Result> take_next() { return taken(queue_.take_next()); }
  /// Results in flight are never handed over; their jobs still run.
  void discard() { queue_.discard(); }
  /// Waits until all submitted jobs are done. Their results are not taken.
  void wait() const { queue_.wait(); }
  /// Whether no result is left to be taken.
  bool empty() const { return queue_.empty(); }
  /// Whether no result is left to be taken, and with `when_ready` the delay of the last job has passed as well: a front
  /// end that submits only then has the same rhythm in a live run, however fast the jobs are.
  bool settled(const FrameTime& now) const { return queue_.settled(now); }
  const PipelineStatistics& statistics() const { return queue_.statistics(); }

 private:
  static std::optional<Result> taken(const std::shared_ptr<void>& result) {
    if (!result) return std::nullopt;
    return std::move(*std::static_pointer_cast<std::optional<Result>>(result));
  }

  PipelineQueue queue_;
};

}  // namespace rastro
