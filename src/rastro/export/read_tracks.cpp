// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/read_tracks.h"

#include <system_error>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/export/tracks_csv.h"
#include "rastro/export/tracks_yaml.h"

namespace rastro {
namespace {

std::filesystem::path file_of(const std::filesystem::path& run) {
  std::error_code ignored;
  if (!std::filesystem::exists(run, ignored)) {
    throw Error("no such file or folder", run.string(), "give the folder that 'rastro track --out' wrote");
  }
  if (!std::filesystem::is_directory(run, ignored)) return run;
  for (const char* name : {"tracks.csv", "tracks.yaml"}) {
    if (std::filesystem::exists(run / name, ignored)) return run / name;
  }
  throw Error("neither tracks.csv nor tracks.yaml in this folder", run.string(),
              "give the folder that 'rastro track --out' wrote");
}

}  // namespace

TrackTable read_tracks(const std::filesystem::path& run_folder_or_file) {
  const std::filesystem::path file = file_of(run_folder_or_file);
  const std::string text = read_whole_file(file);
  TrackTable table =
      file.extension() == ".yaml" ? parse_tracks_yaml(text, file.string()) : parse_tracks_csv(text, file.string());
  if (table.frames.empty()) throw Error("has no complete frame", file.string(), "run 'rastro track' again");
  return table;
}

}  // namespace rastro
