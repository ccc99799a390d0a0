// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "rastro/base/error.h"
#include "rastro/base/text_file.h"
#include "rastro/sensor/trajectory_columns.h"

namespace rastro {
namespace {

constexpr double farthest_m = 1e12;

std::string times_beside(const std::string& file, std::size_t pose_count) {
  const std::filesystem::path path(file);
  for (const auto& candidate :
       {path.parent_path() / (path.stem().string() + "_times.txt"), path.parent_path() / "times.txt"}) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(candidate, ignored)) continue;
    if (content_lines(read_text_file(candidate.string())).size() >= pose_count) return candidate.string();
  }
  return "";
}

std::vector<TimeNs> read_times(const std::string& file, std::size_t pose_count, StampUnit& unit) {
  const std::string text = read_text_file(file);
  unit = guess_column_unit(text, StampUnit::seconds);
  std::vector<TimeNs> times = parse_kitti_times(text, file, unit);
  if (times.size() < pose_count)
    throw Error(fmt::format("has {} stamps for {} poses", times.size(), pose_count), file, "");
  if (std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) != times.end())
    throw Error("has stamps that do not increase", file, "one stamp per line, in the order of the poses");
  return times;
}

void read_kitti(const std::string& text, const std::string& times_file, TrajectoryInput& input) {
  input.matrices = parse_kitti_matrices(text, input.file);
  const std::string times_from = times_file.empty() ? times_beside(input.file, input.matrices.size()) : times_file;
  input.has_stamps = !times_from.empty();
  std::vector<TimeNs> times;
  if (input.has_stamps) {
    StampUnit unit = StampUnit::seconds;
    times = read_times(times_from, input.matrices.size(), unit);
    input.stamps_from =
        fmt::format("of {}, in {}", std::filesystem::path(times_from).filename().string(), unit_name(unit));
  }
  for (std::size_t k = 0; k < input.matrices.size(); ++k) {
    const TimeNs stamp = input.has_stamps ? times[k] : static_cast<TimeNs>(k) * ns_per_second;
    input.poses.push_back({stamp, SE3::from_matrix(input.matrices[k])});
  }
}

void set_matrices(TrajectoryInput& input) {
  for (const StampedPose& pose : input.poses) input.matrices.push_back(pose.world_from_body.matrix());
}

/// Squares of distances must stay finite.
void require_near(const TrajectoryInput& input) {
  for (const StampedPose& pose : input.poses)
    if (pose.world_from_body.translation().cwiseAbs().maxCoeff() > farthest_m)
      throw Error(fmt::format("a position is more than {:g} m away", farthest_m), input.file, "");
}

const char* name_of(TrajectoryFormat format) {
  switch (format) {
    case TrajectoryFormat::tum:
      return "TUM";
    case TrajectoryFormat::euroc:
      return "EuRoC";
    case TrajectoryFormat::kitti:
      return "KITTI";
  }
  return "";
}

}  // namespace

TrajectoryInput read_trajectory_input(const std::string& file, const std::string& times_file) {
  const std::string text = with_commented_names(read_text_file(file));
  TrajectoryInput input;
  input.file = file;
  input.format = guess_trajectory_format(text, file);
  if (input.format == TrajectoryFormat::kitti) {
    read_kitti(text, times_file, input);
    require_near(input);
    return input;
  }
  const bool tum = input.format == TrajectoryFormat::tum;
  const StampUnit unit = guess_column_unit(text, tum ? StampUnit::seconds : StampUnit::nanoseconds);
  input.stamps_from = fmt::format("in {}", unit_name(unit));
  input.poses = tum ? parse_tum_trajectory(text, file, unit) : parse_euroc_trajectory(text, file, unit);
  require_near(input);
  set_matrices(input);
  return input;
}

TrajectoryInput trajectory_input_from(Trajectory trajectory, const std::string& file) {
  TrajectoryInput input;
  input.file = file;
  input.poses = std::move(trajectory);
  input.of_recording = true;
  input.stamps_from = "of the recording";
  set_matrices(input);
  return input;
}

std::string describe(const TrajectoryInput& input) {
  return fmt::format("{} ({}, {} poses, {})", input.file, input.of_recording ? "recording" : name_of(input.format),
                     input.poses.size(), input.has_stamps ? "stamps " + input.stamps_from : "no stamps");
}

}  // namespace rastro
