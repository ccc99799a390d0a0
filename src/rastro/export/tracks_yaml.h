// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "rastro/base/append_file.h"
#include "rastro/export/tracks_header.h"
#include "rastro/track/track_sink.h"
#include "rastro/track/track_table.h"

namespace rastro {

/// tracks.yaml: opens with cv::FileStorage, yaml-cpp, libyaml and PyYAML. A header (columns, camera, options), then one
/// map per frame whose features stand one to a line. Stamps are quoted, since cv::FileStorage has no 64-bit integers.
class TracksYaml : public TrackSink {
 public:
  TracksYaml(const std::filesystem::path& path, const TracksHeader& header);
  void write(const TrackFrame& frame, GrayView image) override;

 private:
  AppendFile file_;
};

/// Reads the frames of a tracks.yaml written by TracksYaml. A last frame that is incomplete (a killed run) is omitted;
/// other damage is an Error with its line.
TrackTable parse_tracks_yaml(std::string_view text, std::string_view where);

}  // namespace rastro
