// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/recording_of_run.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "rastro/base/text_file.h"
#include "rastro/map/graph/sessions.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// Its about.json; an empty object where it has none.
Json about_of_run(const fs::path& run_or_map) {
  std::error_code ignored;
  const fs::path folder = fs::is_directory(run_or_map, ignored) ? run_or_map : run_or_map.parent_path();
  if (!is_there(folder / "about.json")) return Json::object();
  Json about = Json::parse(read_text_file((folder / "about.json").string()), nullptr, false);
  return about.is_object() ? about : Json::object();
}

/// A path as it was given, from here or from the folder where the run was started; empty where it is gone.
std::string found_from(const fs::path& path, const std::string& working_folder) {
  if (path.empty()) return "";
  if (is_there(path)) return path.string();
  const fs::path from_there = fs::path(working_folder) / path;
  return path.is_relative() && is_there(from_there) ? from_there.string() : "";
}

/// Whether `path` is `folder` or below it, whatever links lead to either.
bool is_in(const fs::path& path, const fs::path& folder) {
  std::error_code code;
  const fs::path whole = fs::canonical(folder, code);
  if (code) return false;
  const fs::path rest = fs::weakly_canonical(path, code).lexically_relative(whole);
  return !code && !rest.empty() && *rest.begin() != "..";
}

/// Formats whose cameras go by a name that --camera takes.
bool names_its_cameras(const std::string& format) { return format != "images" && format != "video"; }

MapRecording part_of(const RecordingOfRun& recording, const std::string& named) { return {recording, named, {}}; }

/// Without keyframes.
std::vector<MapRecording> recordings_of_sessions(const Map& map, const fs::path& run_or_map,
                                                 const RecordingOfRun& of_run) {
  const std::string working_folder = about_of_run(run_or_map).value("working_folder", "");
  std::vector<MapRecording> all;
  for (const MapSession& session : map.sessions) {
    if (session.recording.empty()) {  // as in maps of earlier versions
      all.push_back(part_of(of_run, of_run.path));
    } else {
      all.push_back(part_of({found_from(session.recording, working_folder), ""}, session.recording));
    }
  }
  return all;
}

}  // namespace

RecordingOfRun recording_of_run(const fs::path& run_or_map) {
  const Json about = about_of_run(run_or_map);
  if (!about.contains("input")) return {};
  const auto& input = about["input"];
  if (!input.is_object() || !input.contains("path") || !input["path"].is_string()) return {};
  RecordingOfRun recording;
  recording.path = found_from(input["path"].get<std::string>(), about.value("working_folder", ""));
  if (recording.path.empty()) return {};
  const auto first = Json::json_pointer("/cameras/0/name");
  if (names_its_cameras(input.value("format", "")) && input.contains(first) && input[first].is_string())
    recording.camera = input[first].get<std::string>();
  return recording;
}

std::vector<MapRecording> recordings_of_map(const Map& map, const fs::path& run_or_map, const std::string& given) {
  const RecordingOfRun of_run = recording_of_run(run_or_map);
  if (!given.empty() || map.sessions.size() < 2) {
    std::vector<MapRecording> one = {given.empty() ? part_of(of_run, of_run.path) : part_of({given, ""}, given)};
    for (const Keyframe& keyframe : map.keyframes) one.front().keyframes.insert(keyframe.id);
    return one;
  }
  std::vector<MapRecording> all = recordings_of_sessions(map, run_or_map, of_run);
  if (!of_run.path.empty() && all.back().recording.path == of_run.path) all.back().recording = of_run;
  const auto sessions = sessions_of_keyframes(map);
  for (std::size_t k = 0; k < map.keyframes.size(); ++k)
    if (sessions[k]) all[*sessions[k]].keyframes.insert(map.keyframes[k].id);
  std::erase_if(all, [](const MapRecording& part) { return part.keyframes.empty(); });
  return all;
}

std::optional<std::size_t> session_of_reference(const Map& map, const fs::path& run_or_map, const fs::path& reference) {
  const auto all = recordings_of_sessions(map, run_or_map, recording_of_run(run_or_map));
  for (std::size_t session = all.size(); session > 0; --session)
    if (const std::string& path = all[session - 1].recording.path; !path.empty() && is_in(reference, path))
      return session - 1;
  return std::nullopt;
}

bool any_found(const std::vector<MapRecording>& recordings) {
  return std::any_of(recordings.begin(), recordings.end(),
                     [](const MapRecording& part) { return !part.recording.path.empty(); });
}

}  // namespace rastro::cli
