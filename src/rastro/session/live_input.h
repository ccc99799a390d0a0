// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "rastro/base/clock.h"
#include "rastro/sensor/live_source.h"
#include "rastro/session/live_statistics.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/time_histogram.h"

namespace rastro {

struct LiveInputOptions {
  std::size_t queue = 8;                    ///< Frames that may wait for the method; at least 1.
  std::string user = "the method";          ///< What takes the frames, for messages.
  const std::atomic<bool>* stop = nullptr;  ///< Set from outside (Ctrl-C): next() returns at once. May be null.
  bool drains = false;                      ///< Once stopped, next() still gives the frames that wait.
  /// Called for each frame that arrives, dropped later or not, in the thread that takes them. May be empty.
  std::function<void(const Frame&)> tap = {};
  /// Called by next() in its thread about 20 times a second while no frame comes. May be empty.
  std::function<void(const LiveCondition&)> idle = {};
};

/// A live source as the source of a run: a thread takes its frames into a bounded queue from which the oldest are
/// dropped when the method is too slow. The thread begins with the first next(). What happens (stalled, gone, back,
/// frames dropped) is logged, and written as events of the run.
class LiveInput final : public Source {
 public:
  /// `clock` is that of the source and outlives this.
  LiveInput(std::unique_ptr<LiveSource> source, Clock& clock, LiveInputOptions options);
  ~LiveInput() override;

  const SourceInfo& info() const override { return source_->info(); }
  /// The oldest frame that waits, or the next one that comes. nullopt at the end of the source, or once stopped (with
  /// LiveInputOptions::drains when none waits any more).
  std::optional<Frame> next() override;

  /// The frame that next() returned last has its pose.
  void note_pose();
  /// Where the events go; null: nowhere.
  void set_folder(RunFolder* folder) { folder_ = folder; }
  void set_idle(std::function<void(const LiveCondition&)> idle) { options_.idle = std::move(idle); }
  /// Whether next() ended because of LiveInputOptions::stop.
  bool was_stopped() const { return was_stopped_; }
  LiveStatistics statistics() const;

 private:
  struct Waiting {
    std::optional<ArrivedFrame> frame;
    std::exception_ptr error;
    bool is_last = false;
  };
  /// The last one of dropped frames.
  struct Report {
    std::int64_t dropped = 0;
    std::optional<TimeNs> time;
  };
  struct Event {
    std::string kind, text;
  };

  void start();
  void take_frames();
  Waiting take_one();
  void note_condition();
  void push(Waiting item);
  Waiting pop(std::unique_lock<std::mutex>& lock);
  void write_events();
  void report_dropped();
  bool is_stopped() const { return options_.stop && options_.stop->load(); }

  std::unique_ptr<LiveSource> source_;
  Clock& clock_;
  LiveInputOptions options_;
  RunFolder* folder_ = nullptr;
  // Of the caller's thread.
  std::optional<TimeNs> exposed_;
  TimeNs popped_ = 0;
  TimeHistogram exposure_to_pose_, work_;
  std::int64_t last_index_ = -1;
  Report report_;
  bool was_stopped_ = false;
  // Of the thread that takes frames and, under the lock, of the caller's.
  LiveCondition condition_;
  // Of both.
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Waiting> queue_;
  std::vector<Event> events_;
  LiveStatistics statistics_;
  bool ended_ = false;
  std::atomic<bool> closing_ = false;
  std::thread thread_;  // Last: it uses all of the above.
};

}  // namespace rastro
