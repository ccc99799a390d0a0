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

/// Bar where the number of frames is known, frames, rate, time left.
std::string frames_line(std::int64_t frames_done, std::optional<std::int64_t> frames_asked, double seconds) {
  const double done = static_cast<double>(frames_done);
  const double rate = seconds > 0.0 ? done / seconds : 0.0;
  std::string line = fmt::format("{} frames", frames_done);
  if (frames_asked && *frames_asked > 0) {
    const double frames = static_cast<double>(*frames_asked);
    line = fmt::format("{} {}/{} {:3.0f} %", bar(done / frames), frames_done, *frames_asked, 100.0 * done / frames);
    if (rate > 0.0) line += fmt::format("  {:.0f} s left", std::max(0.0, (frames - done) / rate));
  }
  return line + fmt::format("  {:.1f} frames/s", rate);
}

}  // namespace

std::string progress_line(const TrackProgress& progress, double seconds, double memory_mb) {
  std::string line = frames_line(progress.done, progress.frames, seconds);
  if (progress.last)
    line += fmt::format("  {} features  {}", progress.last->features.size(), name_of(progress.last->health));
  return line + fmt::format("  {:.0f} MB", memory_mb);
}

std::string progress_line(const OdometryProgress& progress, double seconds, double memory_mb) {
  std::string line = frames_line(progress.done, progress.frames, seconds);
  if (progress.last) {
    line += fmt::format("  {} points  {}", progress.last->inliers, name_of(progress.last->state));
    if (progress.last->reason != OdometryReason::none) line += fmt::format(" ({})", name_of(progress.last->reason));
  }
  return line + fmt::format("  {:.0f} MB", memory_mb);
}

std::string progress_line(const SlamProgress& progress, double seconds, double memory_mb) {
  std::string line = frames_line(progress.done, progress.frames, seconds);
  if (progress.last) {
    line += fmt::format("  {}", name_of(progress.last->state));
    if (progress.last->reason != SlamReason::none) line += fmt::format(" ({})", name_of(progress.last->reason));
  }
  if (progress.loops_closed > 0) line += fmt::format("  {} loops", progress.loops_closed);
  return line + fmt::format("  {:.0f} MB", memory_mb);
}

ProgressBar::ProgressBar(bool wanted)
    : wanted_(wanted && isatty(STDERR_FILENO) != 0), begin_(Clock::now()), last_(begin_ - redraw_every) {}

bool ProgressBar::latency_passed() {
  const auto now = Clock::now();
  if (!wanted_ || now - last_ < redraw_every) return false;
  last_ = now;
  return true;
}

void ProgressBar::draw(const std::string& line) {
  shown_ = true;
  fmt::print(stderr, "\r\033[K{}", line);
  std::fflush(stderr);
}

template <typename Progress>
void ProgressBar::show_any(const Progress& progress) {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  if (latency_passed()) draw(progress_line(progress, seconds, resident_memory_mb()));
}

void ProgressBar::show(const TrackProgress& progress) { show_any(progress); }
void ProgressBar::show(const OdometryProgress& progress) { show_any(progress); }
void ProgressBar::show(const SlamProgress& progress) { show_any(progress); }

void ProgressBar::show_steps(const std::string& what, std::size_t done, std::size_t all) {
  // The first step of something is shown at once: it may be the only one that is told.
  if (latency_passed() || (wanted_ && done == 0))
    draw(fmt::format("{} {} {}/{}", bar(static_cast<double>(done) / static_cast<double>(all)), what, done, all));
}

void ProgressBar::clear() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace rastro::cli
