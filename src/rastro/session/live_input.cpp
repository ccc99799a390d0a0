// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/live_input.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"

namespace rastro {
namespace {

constexpr TimeNs patience = ns_per_second / 20;
constexpr TimeNs report_every = 5 * ns_per_second;

double to_ms(TimeNs time) { return static_cast<double>(time) * 1e-6; }

const char* kind_of(LiveState state) {
  switch (state) {
    case LiveState::stalled:
      return "source stalled";
    case LiveState::gone:
      return "source gone";
    case LiveState::ended:
      return "source ended";
    case LiveState::delivering:
      break;
  }
  return "source";
}

/// Other errors end the source.
bool is_of_one_frame(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const UnusableSource&) {
    return false;
  } catch (const Error&) {
    return true;
  } catch (...) {
    return false;
  }
}

}  // namespace

LiveInput::LiveInput(std::unique_ptr<LiveSource> source, Clock& clock, LiveInputOptions options)
    : source_(std::move(source)), clock_(clock), options_(std::move(options)) {
  RASTRO_CHECK(source_ != nullptr && options_.queue > 0, "a live input needs a source and room for a frame");
}

LiveInput::~LiveInput() {
  closing_ = true;
  if (thread_.joinable()) thread_.join();
}

void LiveInput::start() {
  if (thread_.joinable()) return;
  thread_ = std::thread([this] { take_frames(); });
}

void LiveInput::take_frames() {
  while (!closing_.load() && !(options_.drains && is_stopped())) {
    Waiting item = take_one();
    note_condition();
    const bool ended = item.is_last || condition_.state == LiveState::ended;
    if (item.frame && options_.tap) options_.tap(item.frame->frame);
    if (item.frame || item.error) push(std::move(item));
    if (!ended) continue;
    const std::lock_guard lock(mutex_);
    ended_ = true;
    filled_.notify_one();
    return;
  }
}

LiveInput::Waiting LiveInput::take_one() {
  Waiting item;
  try {
    item.frame = source_->next(patience);
  } catch (...) {
    item.error = std::current_exception();
    item.is_last = !is_of_one_frame(item.error);
  }
  return item;
}

/// Said at once, whatever the method is doing.
void LiveInput::note_condition() {
  LiveCondition now = source_->condition();
  if (now.state == condition_.state && now.line == condition_.line) return;
  const bool is_back = now.state == LiveState::delivering &&
                       (condition_.state == LiveState::stalled || condition_.state == LiveState::gone);
  const std::string text = now.line.empty() && is_back ? source_->info().path + ": delivers frames again" : now.line;
  if (!text.empty()) log(is_back ? LogLevel::info : LogLevel::warning, text);
  const std::lock_guard lock(mutex_);
  if (now.state != condition_.state) {
    statistics_.stalls += now.state == LiveState::stalled ? 1 : 0;
    statistics_.losses += now.state == LiveState::gone ? 1 : 0;
  }
  if (!text.empty()) events_.push_back({is_back ? "source back" : kind_of(now.state), text});
  condition_ = std::move(now);
}

void LiveInput::push(Waiting item) {
  const std::lock_guard lock(mutex_);
  // next() may have seen already that none waits.
  if (options_.drains && is_stopped()) return;
  if (item.frame) {
    ++statistics_.arrived;
    statistics_.lost += item.frame->lost_before;
  }
  if (queue_.size() >= options_.queue) {
    queue_.pop_front();
    ++statistics_.dropped;
  }
  queue_.push_back(std::move(item));
  filled_.notify_one();
}

std::optional<Frame> LiveInput::next() {
  start();
  std::unique_lock lock(mutex_);
  for (;;) {
    was_stopped_ = was_stopped_ || is_stopped();
    if (was_stopped_ && (!options_.drains || queue_.empty())) return std::nullopt;
    if (!queue_.empty()) break;
    if (ended_) return std::nullopt;
    if (filled_.wait_for(lock, std::chrono::nanoseconds(patience), [this] { return !queue_.empty() || ended_; }))
      continue;
    const LiveCondition condition = condition_;
    lock.unlock();
    write_events();
    if (options_.idle) options_.idle(condition);
    lock.lock();
  }
  Waiting item = pop(lock);
  if (item.error) std::rethrow_exception(item.error);
  last_index_ = item.frame->frame.index;
  exposed_ = item.frame->exposed;
  return std::move(item.frame->frame);
}

LiveInput::Waiting LiveInput::pop(std::unique_lock<std::mutex>& lock) {
  Waiting item = std::move(queue_.front());
  queue_.pop_front();
  lock.unlock();
  write_events();
  report_dropped();
  popped_ = clock_.now();
  return item;
}

void LiveInput::write_events() {
  std::vector<Event> events;
  {
    const std::lock_guard lock(mutex_);
    events.swap(events_);
  }
  if (!folder_) return;
  for (const Event& event : events) folder_->add_event(last_index_, event.kind, event.text);
}

/// At once the first time, then at most every few seconds.
void LiveInput::report_dropped() {
  std::int64_t dropped = 0;
  {
    const std::lock_guard lock(mutex_);
    dropped = statistics_.dropped;
  }
  if (dropped == report_.dropped || (report_.time && clock_.now() - *report_.time < report_every)) return;
  const std::string text = fmt::format("{} frames dropped: the method takes {:.0f} ms a frame (95 % within {:.0f} ms)",
                                       dropped - report_.dropped, work_.percentile_ms(0.5), work_.percentile_ms(0.95));
  report_ = {dropped, clock_.now()};
  log_warning(text);
  if (folder_) folder_->add_event(last_index_, "frames dropped", text);
}

void LiveInput::note_pose() {
  if (!exposed_) return;
  const TimeNs now = clock_.now();
  exposure_to_pose_.add(to_ms(now - *exposed_));
  work_.add(to_ms(now - popped_));
  exposed_.reset();
}

LiveStatistics LiveInput::statistics() const {
  const std::lock_guard lock(mutex_);
  LiveStatistics statistics = statistics_;
  statistics.exposure_to_pose = exposure_to_pose_;
  return statistics;
}

}  // namespace rastro
