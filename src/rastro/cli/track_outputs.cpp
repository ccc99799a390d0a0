// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/track_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/export/track_images.h"
#include "rastro/export/track_table.h"
#include "rastro/export/tracks_jsonl.h"
#include "rastro/export/tracks_yaml.h"
#include "rastro/export/video.h"

namespace rastro::cli {
namespace {

const std::vector<std::string> known_formats = {"yaml", "csv", "jsonl"};

bool wants(const TrackFlags& flags, const std::string& format) {
  return std::find(flags.formats.begin(), flags.formats.end(), format) != flags.formats.end();
}

void check_formats(const TrackFlags& flags) {
  for (const std::string& format : flags.formats) {
    if (std::find(known_formats.begin(), known_formats.end(), format) != known_formats.end()) continue;
    throw Error(fmt::format("'{}' is not a format of tracks", format), "--formats",
                did_you_mean(format, known_formats));
  }
}

std::vector<TrackSink*> pointers(const std::vector<std::unique_ptr<TrackSink>>& sinks) {
  std::vector<TrackSink*> result;
  for (const auto& sink : sinks) result.push_back(sink.get());
  return result;
}

}  // namespace

void check_outputs(const TrackFlags& flags) {
  check_formats(flags);
  match_frames(flags);
  table_frames(flags);
  if (!flags.video.empty()) TrackVideo{flags.video};
}

TrackOutputs::TrackOutputs(const TrackFlags& flags, const RunFolder& folder, const TracksHeader& header) {
  add_text(flags, folder, header);
  add_track_images(flags, folder);
}

void TrackOutputs::add_text(const TrackFlags& flags, const RunFolder& folder, const TracksHeader& header) {
  std::string files;
  if (wants(flags, "yaml")) {
    text_.push_back(std::make_unique<TracksYaml>(folder.file("tracks.yaml"), header));
    files += "tracks.yaml ";
  }
  csv_ = std::make_unique<TracksCsv>(wants(flags, "csv") ? std::optional(folder.file("tracks.csv")) : std::nullopt);
  if (wants(flags, "csv")) files += "tracks.csv ";
  if (wants(flags, "jsonl")) {
    text_.push_back(std::make_unique<TracksJsonl>(folder.file("tracks.jsonl")));
    files += "tracks.jsonl ";
  }
  if (!files.empty()) contents_.emplace_back(files, "the tracks");
  text_.push_back(std::make_unique<TrackTableFile>(folder.file("table.md"), table_frames(flags)));
  contents_.emplace_back("table.md", "features tracked and re-identified per frame");
}

void TrackOutputs::add_track_images(const TrackFlags& flags, const RunFolder& folder) {
  if (flags.images) {
    images_.push_back(std::make_unique<TrackImages>(folder.file("track_images")));
    contents_.emplace_back("track_images/", "every frame with its features");
  }
  if (const auto frames = match_frames(flags)) {
    match_name_ = fmt::format("match_{}_{}.png", frames->first, frames->second);
    auto match = std::make_unique<MatchImage>(folder.file(match_name_), frames->first, frames->second);
    match_ = match.get();
    images_.push_back(std::move(match));
  }
  if (!flags.video.empty()) {
    images_.push_back(std::make_unique<TrackVideo>(flags.video));
    contents_.emplace_back(flags.video, "the drawn frames as a video");
  }
}

std::vector<TrackSink*> TrackOutputs::text_sinks() const {
  std::vector<TrackSink*> sinks = pointers(text_);
  sinks.push_back(csv_.get());
  return sinks;
}

std::vector<TrackSink*> TrackOutputs::image_sinks() const { return pointers(images_); }

std::vector<std::pair<std::string, std::string>> TrackOutputs::contents() const {
  auto written = contents_;
  if (match_ && match_->counts())
    written.emplace_back(match_name_, "magenta: tracked throughout, green: lost and re-identified");
  return written;
}

}  // namespace rastro::cli
