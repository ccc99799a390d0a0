// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/pipeline.h"

#include "rastro/base/stopwatch.h"

namespace rastro {

bool PipelineQueue::submit(std::function<void()> job, std::shared_ptr<void> result, const FrameTime& now,
                           const HandOverDelay& delay) {
  const bool live = options_.hand_over == HandOver::when_ready;
  if (live && options_.max_under_way > 0 && under_way_.size() >= options_.max_under_way) {
    ++statistics_.dropped;
    return false;
  }
  UnderWay item;
  item.job = background_.submit(std::move(job));
  item.due_frame = now.number + delay.frames;
  if (delay.time) item.due_time = now.stamp + *delay.time;
  item.last_frame = item.due_frame + delay.max_extra_frames;
  item.result = std::move(result);
  under_way_.push_back(std::move(item));
  ++statistics_.jobs;
  return true;
}

bool PipelineQueue::is_due(const UnderWay& item, const FrameTime& now) {
  if (now.number < item.due_frame) return false;
  return !item.due_time || *item.due_time <= now.stamp || item.last_frame <= now.number;
}

bool PipelineQueue::is_ready(UnderWay& item, const FrameTime& now) {
  if (background_.is_done(item.job)) return true;
  if (is_due(item, now) && !item.postponed) {
    item.postponed = true;
    ++statistics_.postponed;
  }
  return false;
}

std::shared_ptr<void> PipelineQueue::take_due(const FrameTime& now) {
  if (under_way_.empty()) return nullptr;
  UnderWay& next = under_way_.front();
  const bool live = options_.hand_over == HandOver::when_ready;
  return (live ? is_ready(next, now) : is_due(next, now)) ? take_next() : nullptr;
}

std::shared_ptr<void> PipelineQueue::take_next() {
  if (under_way_.empty()) return nullptr;
  // Taken off first: a result whose job failed is not asked for twice.
  const UnderWay next = std::move(under_way_.front());
  under_way_.pop_front();
  Stopwatch waiting;
  background_.wait(next.job);
  statistics_.wait_ms += waiting.lap_ms();
  ++statistics_.handed_over;
  return next.result;
}

}  // namespace rastro
