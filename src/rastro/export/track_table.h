// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "rastro/base/append_file.h"
#include "rastro/track/track_sink.h"

namespace rastro {

/// The last row of the table: means over the frames in which a feature was lost.
class TrackTableMeans {
 public:
  void add(const TrackFrame& frame);

  int frames() const { return frames_; }  ///< In which a feature was lost; the means are 0 without any.
  double tracked() const { return mean(tracked_); }
  double reidentified() const { return mean(reidentified_); }
  double time_ms() const { return mean(time_ms_); }
  /// Over those of these frames in which a corner was detected; nullopt without any.
  std::optional<double> reidentified_percent() const;

 private:
  double mean(double sum) const { return frames_ > 0 ? sum / frames_ : 0.0; }

  int frames_ = 0, frames_with_detections_ = 0;
  double tracked_ = 0.0, reidentified_ = 0.0, percent_ = 0.0, time_ms_ = 0.0;
};

/// table.md: the columns of Table I of Galardi, Castro, Pire, "Seguimiento Robusto de Caracteristicas Visuales para
/// Sistemas SLAM", one row per frame, and at the end the mean over the rows in which a feature was lost.
class TrackTableFile : public TrackSink {
 public:
  /// First and end of the frames in it, the end not included; nullopt: all.
  using Frames = std::optional<std::pair<std::int64_t, std::int64_t>>;

  explicit TrackTableFile(const std::filesystem::path& path, const Frames& frames = std::nullopt);
  void write(const TrackFrame& frame, GrayView image) override;
  /// Writes the row of means.
  void finish() override;

  /// Re-identified corners as a percentage of all corners detected in the frame; nullopt when there were none.
  static std::optional<double> reidentified_percent(const TrackFrame& frame);

 private:
  AppendFile file_;
  Frames frames_;
  TrackTableMeans means_;
};

}  // namespace rastro
