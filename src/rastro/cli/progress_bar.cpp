// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "rastro/base/memory.h"

namespace rastro::cli {
namespace {

constexpr int bar_width = 24;
constexpr auto redraw_every = std::chrono::milliseconds(100);

std::string bar(double share) {
  const auto filled = static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * bar_width);
  return "[" + std::string(filled, '#') + std::string(bar_width - filled, '.') + "]";
}

}  // namespace

std::string progress_line(const TrackProgress& progress, double seconds, double memory_mb) {
  const double done = static_cast<double>(progress.done);
  const double rate = seconds > 0.0 ? done / seconds : 0.0;
  std::string line;
  if (progress.frames && *progress.frames > 0) {
    const double frames = static_cast<double>(*progress.frames);
    line =
        fmt::format("{} {}/{} {:3.0f} %", bar(done / frames), progress.done, *progress.frames, 100.0 * done / frames);
    if (rate > 0.0) line += fmt::format("  {:.0f} s left", std::max(0.0, (frames - done) / rate));
  } else {
    line = fmt::format("{} frames", progress.done);
  }
  line += fmt::format("  {:.1f} frames/s", rate);
  if (progress.last)
    line += fmt::format("  {} features  {}", progress.last->features.size(), name_of(progress.last->health));
  return line + fmt::format("  {:.0f} MB", memory_mb);
}

ProgressBar::ProgressBar(bool wanted)
    : wanted_(wanted && isatty(STDERR_FILENO) != 0), begin_(Clock::now()), last_(begin_ - redraw_every) {}

void ProgressBar::show(const TrackProgress& progress) {
  const auto now = Clock::now();
  if (!wanted_ || now - last_ < redraw_every) return;
  last_ = now;
  shown_ = true;
  const double seconds = std::chrono::duration<double>(now - begin_).count();
  fmt::print(stderr, "\r\033[K{}", progress_line(progress, seconds, resident_memory_mb()));
  std::fflush(stderr);
}

void ProgressBar::clear() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace rastro::cli
