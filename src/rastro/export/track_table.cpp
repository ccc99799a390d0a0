// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/track_table.h"

#include <fmt/format.h>

namespace rastro {
namespace {

std::string percent_text(std::optional<double> percent) { return percent ? fmt::format("{:.2f}", *percent) : "-"; }

}  // namespace

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
  const std::optional<double> percent = reidentified_percent(frame);
  file_.append(fmt::format("| {} | {} | {} | {} | {:.2f} |\n", frame.index, frame.tracked, frame.reidentified,
                           percent_text(percent), frame.times.total_ms));
  if (frame.lost == 0) return;
  ++rows_with_loss_;
  tracked_ += frame.tracked;
  reidentified_ += frame.reidentified;
  time_ms_ += frame.times.total_ms;
  if (percent) {
    ++rows_with_detections_;
    percent_ += *percent;
  }
}

void TrackTableFile::finish() {
  if (rows_with_loss_ == 0) {
    file_.append("\nNo frame lost a feature, so there is no mean.\n");
    return;
  }
  const auto percent = rows_with_detections_ > 0 ? std::optional(percent_ / rows_with_detections_) : std::nullopt;
  file_.append(fmt::format("| **mean** | {:.1f} | {:.1f} | {} | {:.2f} |\n", tracked_ / rows_with_loss_,
                           reidentified_ / rows_with_loss_, percent_text(percent), time_ms_ / rows_with_loss_));
  file_.append(
      fmt::format("\nKLT: features tracked from the previous frame. %: re-identified, of the corners detected in the "
                  "frame (new and\n"
                  "re-identified). Mean over the {} frames in which a feature was lost.\n",
                  rows_with_loss_));
}

}  // namespace rastro
