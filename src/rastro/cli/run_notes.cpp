// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/run_notes.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/keyframe_images.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/evaluate/pose_consistency.h"
#include "rastro/evaluate/trajectory_scores.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

bool has_file(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && fs::file_size(file, ignored) > 0;
}

/// The columns of stats.csv that are used; those of odometry and SLAM have the same names.
struct StatsColumns {
  std::size_t frame = 0, stamp = 0, state = 0, milliseconds = 0, count = 0;
};

std::size_t column_of(const std::vector<std::string_view>& names, std::string_view name, const std::string& where) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error("has no column " + in_quotes(name), where, "it is not of 'rastro slam' or 'rastro odometry'");
  return static_cast<std::size_t>(found - names.begin());
}

RunRecord::Frame frame_in_row(std::string_view row, const StatsColumns& columns, const std::string& where) {
  const auto cells = split(row, ',');
  if (cells.size() != columns.count) throw Error("is no row of the table", where, "the file is damaged; remove it");
  const auto frame = parse_int64(cells[columns.frame]), stamp = parse_int64(cells[columns.stamp]);
  const auto milliseconds = parse_finite(cells[columns.milliseconds]);
  if (!frame || !stamp || !milliseconds) throw Error("has no numbers", where, "the file is damaged; remove it");
  return {*frame, *stamp, std::string(cells[columns.state]), *milliseconds};
}

std::vector<RunRecord::Frame> read_stats(const std::string& file) {
  const std::string text = read_text_file(file);
  const auto lines = content_lines(text);
  if (lines.empty()) return {};
  const auto names = split(lines.front().text, ',');
  const StatsColumns columns{column_of(names, "frame", file), column_of(names, "stamp_ns", file),
                             column_of(names, "state", file), column_of(names, "total_ms", file), names.size()};
  std::vector<RunRecord::Frame> frames;
  for (std::size_t k = 1; k < lines.size(); ++k)
    frames.push_back(frame_in_row(lines[k].text, columns, at_line(file, lines[k].number)));
  return frames;
}

std::vector<RunRecord::Event> read_events(const std::string& file) {
  const std::string text = read_text_file(file);
  std::vector<RunRecord::Event> events;
  for (const TextLine& line : content_lines(text)) {
    const auto json = nlohmann::json::parse(line.text, nullptr, false);
    const bool sound = json.is_object() && json.contains("frame") && json["frame"].is_number_integer() &&
                       json.contains("event") && json["event"].is_string();
    if (!sound) throw Error("is no event", at_line(file, line.number), "the file is damaged; remove it");
    const auto detail = json.find("text");
    events.push_back({json["frame"].get<std::int64_t>(), json["event"].get<std::string>(),
                      detail != json.end() && detail->is_string() ? detail->get<std::string>() : std::string()});
  }
  return events;
}

std::vector<RunRecord::Uncertainty> read_uncertainties(const std::string& file) {
  std::vector<RunRecord::Uncertainty> uncertainties;
  for (const StampedCovariance& each : parse_pose_covariances(read_text_file(file), file))
    uncertainties.push_back({each.stamp, each.covariance.topLeftCorner<3, 3>()});
  return uncertainties;
}

/// The ground truth of the recording, moved into the world of the run.
void align_truth(const std::string& folder, const std::string& recording, bool metric, RunRecord& record) {
  const ReferenceTrajectory reference = read_reference(recording, {});
  const TrajectoryInput estimate = read_estimate(folder, reference, {});
  TrajectoryScoreOptions options;
  options.alignment = metric ? TrajectoryAlignment::se3 : TrajectoryAlignment::sim3;
  const TrajectoryScores scores = score_trajectory(reference.input, estimate, options);
  const Sim3 estimate_from_reference = scores.reference_from_estimate.inverse();
  // Where both were compared as poses of the body, the camera is where it sits on it.
  const SE3 body_from_camera = reference.body_from_camera_of_estimates.value_or(SE3());
  const SE3 camera_from_body = body_from_camera.inverse();
  for (const PosePair& pair : scores.pairs) {
    const SE3& pose = reference.input.poses[pair.reference].world_from_body;
    const Eigen::Vector3d position = estimate_from_reference * (pose * body_from_camera.translation());
    record.truth.push_back({estimate.poses[pair.estimate].stamp, camera_from_body * position});
  }
}

void add_truth(const ExportInput& input, RunRecord& record) {
  const std::string recording = recording_of_run(input.path).path;
  if (recording.empty() || !has_file(fs::path(input.path) / "trajectory.txt")) return;
  const bool metric = input.map && scale_of(*input.map).metric;
  try {
    align_truth(input.path, recording, metric, record);
  } catch (const Error& error) {
    // Most recordings have none, and the run is worth seeing without it.
    record.truth.clear();
    log(LogLevel::debug, error.what());
  }
}

}  // namespace

RunRecord notes_of_run(const ExportInput& input) {
  RunRecord record;
  record.trajectory = input.trajectory;
  std::error_code ignored;
  const fs::path folder = input.path;
  if (!fs::is_directory(folder, ignored)) return record;
  const auto file = [&folder](const char* name) { return (folder / name).string(); };
  if (has_file(file("stats.csv"))) record.frames = read_stats(file("stats.csv"));
  if (has_file(file("events.jsonl"))) record.events = read_events(file("events.jsonl"));
  if (has_file(file("covariance_online.txt"))) record.uncertainties = read_uncertainties(file("covariance_online.txt"));
  // A run without a pose has only the header.
  if (has_file(file("trajectory_online.txt")) && !record.trajectory.empty())
    record.online = read_trajectory(file("trajectory_online.txt"));
  add_truth(input, record);
  return record;
}

}  // namespace rastro::cli
