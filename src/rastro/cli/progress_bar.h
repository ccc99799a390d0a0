// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "rastro/session/odometry_run.h"
#include "rastro/session/slam_run.h"
#include "rastro/session/track_run.h"

namespace rastro::cli {

/// One line on standard error that is redrawn at most ten times a second; nothing where that is no terminal.
class ProgressBar {
 public:
  explicit ProgressBar(bool wanted);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(const TrackProgress& progress);
  void show(const OdometryProgress& progress);
  void show(const SlamProgress& progress);
  /// Of something that is no run over frames: what is done, how many of how many.
  void show_steps(const std::string& what, std::size_t done, std::size_t all);
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool shown_ = false;
  bool wanted_;
  bool latency_passed();
  void draw(const std::string& line);
  template <typename Progress>
  void show_any(const Progress& progress);
  Clock::time_point begin_;
  Clock::time_point last_;
};

/// The line itself: bar where the number of frames is known, rate, features, health, memory, time left.
std::string progress_line(const TrackProgress& progress, double seconds, double memory_mb);
std::string progress_line(const OdometryProgress& progress, double seconds, double memory_mb);
std::string progress_line(const SlamProgress& progress, double seconds, double memory_mb);

}  // namespace rastro::cli
