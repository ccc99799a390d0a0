// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/track_table.h"

#include <fmt/format.h>

namespace rastro {
namespace {

std::string percent_text(std::optional<double> percent) { return percent ? fmt::format("{:.2f}", *percent) : "-"; }

}  // namespace

void TrackTableMeans::add(const TrackFrame& frame) {
  if (frame.lost == 0) return;
  ++frames_;
  tracked_ += frame.tracked;
  reidentified_ += frame.reidentified;
  time_ms_ += frame.times.total_ms;
  if (const auto percent = TrackTableFile::reidentified_percent(frame)) {
    ++frames_with_detections_;
    percent_ += *percent;
  }
}

std::optional<double> TrackTableMeans::reidentified_percent() const {
  if (frames_with_detections_ == 0) return std::nullopt;
  return percent_ / frames_with_detections_;
}

TrackTableFile::TrackTableFile(const std::filesystem::path& path, const Frames& frames) : file_(path), frames_(frames) {
  file_.append(
      "| frame | KLT | # re-identified | % re-identified | time ms |\n"
      "| ---: | ---: | ---: | ---: | ---: |\n");
}

std::optional<double> TrackTableFile::reidentified_percent(const TrackFrame& frame) {
  const int detected = frame.reidentified + frame.fresh;
  if (detected == 0) return std::nullopt;
  return 100.0 * frame.reidentified / detected;
}

void TrackTableFile::write(const TrackFrame& frame, GrayView) {
  if (frames_ && (frame.index < frames_->first || frame.index >= frames_->second)) return;
  file_.append(fmt::format("| {} | {} | {} | {} | {:.2f} |\n", frame.index, frame.tracked, frame.reidentified,
                           percent_text(reidentified_percent(frame)), frame.times.total_ms));
  means_.add(frame);
}

void TrackTableFile::finish() {
  if (means_.frames() == 0) {
    file_.append("\nNo frame lost a feature, so there is no mean.\n");
    return;
  }
  file_.append(fmt::format("| **mean** | {:.1f} | {:.1f} | {} | {:.2f} |\n", means_.tracked(), means_.reidentified(),
                           percent_text(means_.reidentified_percent()), means_.time_ms()));
  file_.append(
      fmt::format("\nKLT: features tracked from the previous frame. %: re-identified, of the corners detected in the "
                  "frame (new and\n"
                  "re-identified). Mean over the {} frames in which a feature was lost.\n",
                  means_.frames()));
}

}  // namespace rastro
