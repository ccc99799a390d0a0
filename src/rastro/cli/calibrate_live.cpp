// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>

#include "rastro/base/clock.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/calibration/live_assistant.h"
#include "rastro/cli/calibrate_input.h"
#include "rastro/cli/interrupt.h"
#include "rastro/dataset/live/live.h"

namespace rastro::cli {
namespace {

constexpr TimeNs patience = 100'000'000;

/// Says what changes, not what stays as it is.
class Speaker {
 public:
  explicit Speaker(bool quiet) : quiet_(quiet) {}

  void condition(const LiveCondition& condition) {
    if (condition.line != condition_ && !condition.line.empty()) log_warning(condition.line);
    condition_ = condition.line;
  }
  void taken(const LiveAssistant& assistant) const {
    if (quiet_) return;
    const auto& missing = assistant.missing();
    fmt::print(stderr, "view {} taken{}\n", assistant.input().views.size(),
               missing.empty() ? std::string("; nothing is missing, more views make it surer")
                               : fmt::format("; missing: {}", fmt::join(missing, ", ")));
  }

 private:
  bool quiet_;
  std::string condition_;
};

}  // namespace

BoardImages find_boards_live(const DataFlags& flags, const Board& board, std::size_t most_views) {
  SteadyClock clock;
  const std::atomic<bool>& stop = catch_interrupts();
  const std::unique_ptr<LiveSource> source = open_live(flags.path, open_options(flags), {}, clock, &stop);
  Speaker speaker(flags.quiet);
  BoardImages result;
  std::optional<LiveAssistant> assistant;
  LiveAssistantOptions options;
  options.most_views = static_cast<int>(most_views);
  options.enough_views = std::min(options.enough_views, options.most_views);
  while (!stop && !(assistant && assistant->enough())) {
    const auto arrived = source->next(patience);
    speaker.condition(source->condition());
    if (!arrived) {
      if (source->condition().state == LiveState::ended) break;
      continue;
    }
    const Frame& frame = arrived->frame;
    if (!assistant) assistant.emplace(board, frame.image.width(), frame.image.height(), options);
    if (frame.image.width() != assistant->input().width || frame.image.height() != assistant->input().height)
      throw Error("changes the size of its images", flags.path, "calibrate with images of one size");
    ++result.images;
    if (assistant->offer(detect_board(frame.image.view(), board), frame.name) == LiveAssistant::Answer::taken)
      speaker.taken(*assistant);
  }
  if (!assistant) throw Error("gave no image", flags.path, "'rastro devices' lists what is connected");
  result.input = assistant->input();
  return result;
}

}  // namespace rastro::cli
