// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "rastro/base/background.h"
#include "rastro/base/time.h"

namespace rastro {

/// Which results the front end gets, and when.
enum class HandOver : std::uint8_t {
  /// At a fixed later frame, never earlier; the front end waits for a result that is late. So every run gives the same
  /// bytes, with a thread beside the front end or without one.
  fixed_delay,
  /// As soon as they are ready, for a live run: the front end never waits, and runs may differ.
  when_ready,
};

/// Where the front end is: the number of the frame, of any kind, and its stamp.
struct FrameTime {
  std::int64_t number = 0;
  TimeNs stamp = 0;
};

/// How much later than the frame of its job a result is handed over.
struct HandOverDelay {
  std::int64_t frames = 1;          ///< At least so many, and ...
  std::optional<TimeNs> time = {};  ///< ... so much later by the stamps; nullopt: frames alone count.
  /// Where stamps stand still, frames alone count this many after `frames`.
  std::int64_t max_extra_frames = 0;
};

struct PipelineOptions {
  bool own_thread = false;  ///< False: a job runs in submit().
  HandOver hand_over = HandOver::fixed_delay;
  /// With `when_ready`, results that may be under way: a job beyond that is dropped. 0: any number.
  std::size_t max_under_way = 0;
};

struct PipelineStatistics {
  std::int64_t jobs = 0;         ///< Accepted.
  std::int64_t handed_over = 0;  ///< Results taken.
  double wait_ms = 0.0;          ///< That the front end waited for results.
  std::int64_t postponed = 0;    ///< With `when_ready`: results that were not ready when fixed_delay has them due.
  std::int64_t dropped = 0;      ///< With `when_ready`: jobs that were not accepted.
};

/// The order of jobs and the times at which their results are due, whatever a result is. For Pipeline.
class PipelineQueue {
 public:
  explicit PipelineQueue(const PipelineOptions& options) : options_(options), background_(options.own_thread) {}

  bool submit(std::function<void()> job, std::shared_ptr<void> result, const FrameTime& now,
              const HandOverDelay& delay);
  /// Null: none to be handed over now.
  std::shared_ptr<void> take_due(const FrameTime& now);
  /// Null: none under way.
  std::shared_ptr<void> take_next();
  void discard() { under_way_.clear(); }
  void wait() const { background_.wait_for_all(); }
  bool empty() const { return under_way_.empty(); }
  const PipelineStatistics& statistics() const { return statistics_; }

 private:
  struct UnderWay {
    std::size_t job = 0;
    std::int64_t due_frame = 0;           ///< Number of the first frame that may see the result, ...
    std::optional<TimeNs> due_time = {};  ///< ... its least stamp, ...
    std::int64_t last_frame = 0;          ///< ... and the frame from which stamps no longer count.
    std::shared_ptr<void> result;
    bool postponed = false;
  };

  static bool is_due(const UnderWay& item, const FrameTime& now);
  bool is_ready(UnderWay& item, const FrameTime& now);

  PipelineOptions options_;
  PipelineStatistics statistics_;
  std::deque<UnderWay> under_way_;
  mutable Background background_;
};

/// What a front end has done beside it: jobs run one after the other in the order in which they are given, and their
/// results are handed over in that order. Everything here is called by the front end's thread; a job may use what no
/// one else touches while jobs are under way. An exception of a job is thrown where its result, or a later one, is
/// taken or waited for; no job runs after it.
template <typename Result>
class Pipeline {
 public:
  explicit Pipeline(const PipelineOptions& options) : queue_(options) {}

  /// `now`: the frame that the job belongs to. False: dropped, see PipelineOptions::max_under_way.
  bool submit(std::function<Result()> job, const FrameTime& now, const HandOverDelay& delay) {
    const auto result = std::make_shared<std::optional<Result>>();
    return queue_.submit([job = std::move(job), result] { result->emplace(job()); }, result, now, delay);
  }
  /// The oldest result, if it is to be handed over by `now`; ask again until there is none.
  std::optional<Result> take_due(const FrameTime& now) { return taken(queue_.take_due(now)); }
  /// The oldest result, whenever it is due; waits for it. nullopt: none under way.
  std::optional<Result> take_next() { return taken(queue_.take_next()); }
  /// Results under way are never handed over; their jobs run all the same.
  void discard() { queue_.discard(); }
  /// Until all jobs given so far are done. Their results stay to be taken.
  void wait() const { queue_.wait(); }
  /// No result is to be taken any more.
  bool empty() const { return queue_.empty(); }
  const PipelineStatistics& statistics() const { return queue_.statistics(); }

 private:
  static std::optional<Result> taken(const std::shared_ptr<void>& result) {
    if (!result) return std::nullopt;
    return std::move(*std::static_pointer_cast<std::optional<Result>>(result));
  }

  PipelineQueue queue_;
};

}  // namespace rastro
