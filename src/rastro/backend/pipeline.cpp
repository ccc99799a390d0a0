// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/pipeline.h"

#include "rastro/base/stopwatch.h"

namespace rastro {

PipelineOptions mapping_pipeline(bool pipelined, bool live, const TaskPool* pool) {
  constexpr std::size_t most_live = 4;
  PipelineOptions options;
  options.own_thread = pipelined && pool != nullptr && pool->threads() > 1;
  if (!live) return options;
  options.hand_over = HandOver::when_ready;
  options.max_in_flight = most_live;
  return options;
}

bool PipelineQueue::has_room() const {
  const bool live = options_.hand_over == HandOver::when_ready;
  return !live || options_.max_in_flight == 0 || in_flight_.size() < options_.max_in_flight;
}

bool PipelineQueue::accepts() {
  if (has_room()) return true;
  ++statistics_.dropped;
  return false;
}

bool PipelineQueue::submit(std::function<void()> job, std::shared_ptr<void> result, const FrameTime& now,
                           const HandOverDelay& delay) {
  if (!accepts()) return false;
  InFlight item;
  item.job = background_.submit(std::move(job));
  item.handover_frame = now.number + delay.frames;
  if (delay.time) item.handover_time = now.stamp + *delay.time;
  item.last_frame = item.handover_frame + delay.max_extra_frames;
  last_ = item;
  item.result = std::move(result);
  in_flight_.push_back(std::move(item));
  ++statistics_.jobs;
  return true;
}

bool PipelineQueue::settled(const FrameTime& now) const {
  return in_flight_.empty() && (options_.hand_over == HandOver::fixed_delay || latency_passed(last_, now));
}

bool PipelineQueue::latency_passed(const InFlight& item, const FrameTime& now) {
  if (now.number < item.handover_frame) return false;
  return !item.handover_time || *item.handover_time <= now.stamp || item.last_frame <= now.number;
}

bool PipelineQueue::is_ready(InFlight& item, const FrameTime& now) {
  if (background_.is_done(item.job)) return true;
  if (latency_passed(item, now) && !item.postponed) {
    item.postponed = true;
    ++statistics_.postponed;
  }
  return false;
}

std::shared_ptr<void> PipelineQueue::take_ready(const FrameTime& now) {
  if (in_flight_.empty()) return nullptr;
  InFlight& next = in_flight_.front();
  const bool live = options_.hand_over == HandOver::when_ready;
  return (live ? is_ready(next, now) : latency_passed(next, now)) ? take_next() : nullptr;
}

std::shared_ptr<void> PipelineQueue::take_next() {
  if (in_flight_.empty()) return nullptr;
  // Removed first, so that a result whose job failed is not requested twice.
  const InFlight next = std::move(in_flight_.front());
  in_flight_.pop_front();
  Stopwatch waiting;
  background_.wait(next.job);
  statistics_.wait_ms += waiting.lap_ms();
  ++statistics_.handed_over;
  return next.result;
}

}  // namespace rastro
