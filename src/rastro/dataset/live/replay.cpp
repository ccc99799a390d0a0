// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr TimeNs usual_period = ns_per_second / 30;
constexpr TimeNs late_from = ns_per_second / 5;  // what a busy machine may take to wake a thread

class ReplaySource final : public LiveSource {
 public:
  ReplaySource(std::function<std::unique_ptr<Source>()> open, const ReplayOptions& options, Clock& clock)
      : open_(std::move(open)), options_(options), clock_(clock), source_(open_()), info_(source_->info()) {
    if (options.loop) info_.frame_count = -1;
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<ArrivedFrame> next(TimeNs patience) override {
    if (!waiting_) fetch();
    if (!waiting_) return std::nullopt;
    const TimeNs due = due_time();
    const TimeNs wait = due - clock_.now();
    if (wait > patience) {
      clock_.sleep_for(patience);
      return std::nullopt;
    }
    if (wait > 0) clock_.sleep_for(wait);
    if (-wait > late_from) slow_down(-wait);
    last_due_ = std::max(due, -wait > late_from ? clock_.now() : due);
    Frame frame = std::move(*waiting_);
    waiting_.reset();
    return ArrivedFrame{std::move(frame), *last_due_, 0};
  }

  LiveCondition condition() const override {
    if (ended_) return {LiveState::ended, ""};
    if (late_ < ns_per_second) return {};
    return {LiveState::delivering,
            fmt::format("{}: frames cannot be read at {:g} times their pace; the replay is slower", info_.path,
                        options_.speed)};
  }

 private:
  void fetch() {
    if (ended_) return;
    if (!begins_again_) waiting_ = source_->next();
    if (!waiting_ && options_.loop && frames_ > 0) rewind();
    if (!waiting_) {
      ended_ = true;
      return;
    }
    const TimeNs recorded = waiting_->stamp;
    if (frames_ == 0) first_stamp_ = recorded;
    if (frames_ > 0 && recorded > last_recorded_) period_ = recorded - last_recorded_;
    last_recorded_ = recorded;
    last_index_ = waiting_->index;
    ++frames_;
    waiting_->stamp += stamp_offset_;
    waiting_->depth_stamp += stamp_offset_;
    waiting_->index += index_offset_;
  }

  /// Goes on where an earlier call threw since the first frames cannot be read.
  void rewind() {
    if (!begins_again_) open_again();
    begins_again_ = true;
    waiting_ = source_->next();
    begins_again_ = false;
    if (!waiting_) return;
    stamp_offset_ += last_recorded_ + period_ - waiting_->stamp;
    index_offset_ += last_index_ + 1 - waiting_->index;
    last_recorded_ = waiting_->stamp - period_;
  }

  /// A recording that is gone ends the replay, or it would be tried forever.
  void open_again() {
    ended_ = true;
    source_ = open_();
    ended_ = false;
  }

  /// Stamps that do not rise are due at once.
  TimeNs due_time() {
    if (!begin_) begin_ = clock_.now();
    const double since_first = static_cast<double>(waiting_->stamp - first_stamp_) / options_.speed;
    return std::max(*begin_ + static_cast<TimeNs>(std::llround(since_first)), last_due_.value_or(*begin_));
  }

  void slow_down(TimeNs by) {
    begin_ = *begin_ + by;
    late_ += by;
  }

  std::function<std::unique_ptr<Source>()> open_;
  ReplayOptions options_;
  Clock& clock_;
  std::unique_ptr<Source> source_;
  SourceInfo info_;
  std::optional<Frame> waiting_;
  std::optional<TimeNs> begin_, last_due_;
  std::int64_t frames_ = 0;
  TimeNs first_stamp_ = 0, last_recorded_ = 0, period_ = usual_period, stamp_offset_ = 0;
  std::int64_t last_index_ = -1, index_offset_ = 0;
  TimeNs late_ = 0;
  bool begins_again_ = false;  ///< No frame was read since the recording was opened again.
  bool ended_ = false;
};

}  // namespace

std::unique_ptr<LiveSource> make_replay(std::function<std::unique_ptr<Source>()> open, const ReplayOptions& options,
                                        Clock& clock) {
  if (!(options.speed >= 0.01 && options.speed <= 100.0))
    throw Error(fmt::format("{:g} is not a speed of a replay", options.speed), "--speed",
                "give how many times as fast as recorded, from 0.01 to 100");
  return std::make_unique<ReplaySource>(std::move(open), options, clock);
}

}  // namespace rastro
