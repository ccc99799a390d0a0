// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rastro/cli/track_flags.h"
#include "rastro/export/match_image.h"
#include "rastro/export/tracks_csv.h"
#include "rastro/export/tracks_header.h"
#include "rastro/session/run_folder.h"
#include "rastro/track/track_sink.h"

namespace rastro::cli {

/// Error for outputs that cannot be written as the flags ask; before anything is written.
void check_outputs(const TrackFlags& flags);

/// The output files of a run that the flags ask for.
class TrackOutputs {
 public:
  TrackOutputs(const TrackFlags& flags, const RunFolder& folder, const TracksHeader& header);

  std::vector<TrackSink*> text_sinks() const;
  std::vector<TrackSink*> image_sinks() const;
  /// SHA-256 of the bytes of tracks.csv, whether it was written or not. Once, after the run.
  std::string result_sha256() { return csv_->sha256(); }
  /// File and what is in it, for the summary, after the run: a match image is written only where both frames came.
  std::vector<std::pair<std::string, std::string>> contents() const;

 private:
  void add_text(const TrackFlags& flags, const RunFolder& folder, const TracksHeader& header);
  void add_track_images(const TrackFlags& flags, const RunFolder& folder);

  std::unique_ptr<TracksCsv> csv_;
  std::vector<std::unique_ptr<TrackSink>> text_;
  std::vector<std::unique_ptr<TrackSink>> images_;
  const MatchImage* match_ = nullptr;  ///< Of images_; null: none was asked for.
  std::string match_name_;
  std::vector<std::pair<std::string, std::string>> contents_;
};

}  // namespace rastro::cli
