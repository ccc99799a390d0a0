// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/run_folder.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "rastro/base/error.h"
#include "rastro/base/memory.h"
#include "rastro/base/text.h"
#include "rastro/base/version.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* files_of_a_run[] = {"about.json",
                                          "options.yaml",
                                          "stats.csv",
                                          "events.jsonl",
                                          "result.json",
                                          "tracks.yaml",
                                          "tracks.csv",
                                          "tracks.jsonl",
                                          "table.md",
                                          "trajectory.txt",
                                          "trajectory_online.txt",
                                          "covariance_online.txt",
                                          "keyframes.txt",
                                          "map.pgm",
                                          "map.yaml",
                                          "map.png",
                                          "places.png",
                                          "landmarks.csv",
                                          "cloud.ply",
                                          "lengths.json",
                                          "lengths_before_scale.json",
                                          "map.rastro",
                                          "map.rastro-wal",
                                          "map.rastro-shm",
                                          "map.rastro.new"};

[[noreturn]] void refuse(const fs::path& folder, const std::string& what, const std::string& remedy) {
  throw Error(what, folder.string(), remedy);
}

/// Images of an earlier, longer run would look like those of a new one.
void add_images(const fs::path& folder, const std::string& begin, std::vector<fs::path>& files) {
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code))
    if (entry.path().extension() == ".png" && entry.path().filename().string().starts_with(begin))
      files.push_back(entry.path());
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code code;
  for (const char* name : files_of_a_run)
    if (fs::is_regular_file(folder / name, code)) files.push_back(folder / name);
  add_images(folder, "match_", files);
  for (const char* name : {"track_images", "pictures"})
    add_images(folder / name, "", files);  // now, in the last release
  return files;
}

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const auto colon = line.find(':');
    if (colon != std::string::npos) return std::string(trim(std::string_view(line).substr(colon + 1)));
  }
  return "unknown";
}

Json machine() {
  Json json;
  utsname system{};
  if (::uname(&system) == 0) {
    json["system"] = fmt::format("{} {} {}", system.sysname, system.release, system.machine);
  }
  json["processor"] = processor_name();
  json["cores"] = std::thread::hardware_concurrency();
  return json;
}

Json described(const CalibratedCamera& calibrated) {
  Json json{{"name", calibrated.name}, {"calibrated", calibrated.camera.has_value()}};
  if (!calibrated.camera) return json;
  const Camera& camera = *calibrated.camera;
  json["calibration_file"] = calibrated.calibration_file;
  json["size_px"] = {camera.width, camera.height};
  json["fx_fy_cx_cy_px"] = {camera.fx, camera.fy, camera.cx, camera.cy};
  json["distortion"] = std::vector<double>(
      camera.coefficients.begin(),
      camera.coefficients.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(5, camera.coefficient_count())));
  return json;
}

std::vector<std::pair<const char*, bool>> sensors_of(const SourceInfo& input) {
  return {{"image", input.has_image}, {"right image", input.has_right}, {"depth", input.has_depth},
          {"scan", input.has_scan},   {"odometry", input.has_odometry}, {"landmarks", input.has_landmarks},
          {"imu", input.has_imu}};
}

Json described(const SourceInfo& input) {
  Json json{{"path", input.path}, {"format", input.format}, {"frames", input.frame_count}};
  json["cameras"] = Json::array();
  for (const CalibratedCamera& camera : input.cameras) json["cameras"].push_back(described(camera));
  for (const auto& [sensor, there] : sensors_of(input))
    if (there) json["sensors"].push_back(sensor);
  json["warnings"] = input.warnings;
  return json;
}

/// Paths and messages may contain bytes that are not UTF-8; they are replaced rather than refused.
std::string text_of(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

RunFolder::RunFolder(fs::path folder, bool overwrite) : folder_(std::move(folder)) {
  std::error_code code;
  if (folder_.empty()) refuse("--out", "no folder given", "give a folder for the results");
  if (fs::exists(folder_, code) && !fs::is_directory(folder_, code)) {
    refuse(folder_, "is a file, not a folder", "give a folder for the results with --out");
  }
  fs::create_directories(folder_, code);
  if (code) refuse(folder_, "cannot be made (" + code.message() + ")", "choose another --out");
  lock_.emplace(folder_);
  const bool empty = fs::is_empty(folder_, code);
  if (code) refuse(folder_, "cannot be read (" + code.message() + ")", "choose another --out");
  if (!empty && !overwrite) refuse(folder_, "the folder is not empty", "choose another --out or add --force");
  former_ = std::make_unique<FormerRun>(folder_, files_in(folder_));
}

RunFolder::~RunFolder() {
  std::error_code ignored;
  if (former_->is_aside() && !fs::exists(file("stats.csv"), ignored)) discard();
}

void RunFolder::write_result(const std::string& json) const {
  write_whole_file(file("result.json"), json);
  former_->remove();
}

void RunFolder::discard() const {
  std::error_code ignored;
  for (const fs::path& each : files_in(folder_)) fs::remove(each, ignored);
  former_->bring_back();
  // remove() leaves nonempty folders alone.
  fs::remove(folder_ / "track_images", ignored);
  fs::remove(folder_, ignored);
}

void RunFolder::write_options(const OptionTable& options) const {
  write_whole_file(file("options.yaml"), options.to_yaml());
}

void RunFolder::write_about(const SourceInfo& input, const std::string& command_line) const {
  const Version& is = version();
  Json json;
  json["program"] = "rastro";
  json["version"] = is.number;
  json["commit"] = is.commit;
  json["compiler"] = is.compiler;
  for (const OptionalPart& part : is.optional_parts) json["optional_parts"][part.name] = part.included;
  json["command_line"] = command_line;
  std::error_code ignored;
  json["working_folder"] = fs::current_path(ignored).string();
  json["machine"] = machine();
  json["input"] = described(input);
  write_whole_file(file("about.json"), text_of(json, 2));
}

void RunFolder::add_stats(const TrackFrame& frame) {
  if (!stats_) {
    stats_.emplace(file("stats.csv"));
    stats_->append(
        "frame,stamp_ns,features,tracked,reidentified,new,lost,masked,health,pyramid_ms,flow_ms,outlier_ms,foresee_ms,"
        "detect_ms,describe_ms,match_ms,validate_ms,total_ms,resident_mb\n");
  }
  const TrackTimes& times = frame.times;
  stats_->append(fmt::format(
      "{},{},{},{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.1f}\n", frame.index,
      frame.stamp, frame.features.size(), frame.tracked, frame.reidentified, frame.fresh, frame.lost, frame.masked,
      name_of(frame.health), times.pyramid_ms, times.flow_ms, times.outlier_ms, times.predict_ms, times.detect_ms,
      times.describe_ms, times.match_ms, times.validate_ms, times.total_ms, resident_memory_mb()));
}

void RunFolder::add_stats(const OdometryUpdate& update) {
  if (!stats_) {
    stats_.emplace(file("stats.csv"));
    stats_->append("frame,stamp_ns,state,reason,used,matches,inliers,confidence,total_ms,resident_mb\n");
  }
  stats_->append(fmt::format("{},{},{},{},{},{},{},{:.4f},{:.4f},{:.1f}\n", update.index, update.stamp,
                             name_of(update.state), name_of(update.reason), update.used ? 1 : 0, update.matches,
                             update.inliers, update.confidence, update.milliseconds, resident_memory_mb()));
}

void RunFolder::add_event(std::int64_t frame, const std::string& kind, const std::string& text) {
  if (!events_) events_.emplace(file("events.jsonl"));
  events_->append(text_of(Json{{"frame", frame}, {"event", kind}, {"text", text}}, -1));
}

}  // namespace rastro
