// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "rastro/base/append_file.h"
#include "rastro/base/hash.h"
#include "rastro/track/track_sink.h"
#include "rastro/track/track_table.h"

namespace rastro {

/// tracks.csv: one row per feature, the facts of its frame repeated at the end of the row; a frame without features has
/// one row with id -1 and state "none". `frame` and `last_seen` are frame numbers of the recording; x and y are pixels
/// of the image as given; ray is the undistorted normalized (x/z, y/z), nan without a calibration.
class TracksCsv : public TrackSink {
 public:
  /// Without a path nothing is written, but the hash of the bytes is still taken.
  explicit TracksCsv(const std::optional<std::filesystem::path>& path);

  void write(const TrackFrame& frame, GrayView image) override;
  /// SHA-256 of the bytes of the file: equal for equal results. Once, after the last frame.
  std::string sha256() { return hash_.finish(); }

 private:
  void append(const std::string& text);

  std::optional<AppendFile> file_;
  Sha256 hash_;
};

/// Reads the text of a tracks.csv. A last frame that is incomplete (a killed run) is omitted, anything else that is not
/// as TracksCsv writes it is an Error with its line; `where` is the file's name.
TrackTable parse_tracks_csv(std::string_view text, std::string_view where);

}  // namespace rastro
