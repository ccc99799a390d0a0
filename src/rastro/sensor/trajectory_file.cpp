// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/trajectory_file.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/sensor/stamp_text.h"
#include "rastro/sensor/trajectory_columns.h"

namespace rastro {
namespace {

constexpr TrajectoryColumns tum_columns{{1, 2, 3}, {4, 5, 6, 7}}, euroc_columns{{1, 2, 3}, {5, 6, 7, 4}};
constexpr double quaternion_tolerance = 0.1;
constexpr double rotation_tolerance = 0.02;

double number_at(std::span<const std::string_view> words, std::size_t column, const std::string& where) {
  const auto number = parse_finite(words[column]);
  if (!number) {
    throw Error(fmt::format("column {} is {}, not a finite number", column + 1, in_quotes(words[column])), where, "");
  }
  return *number;
}

TimeNs stamp_at(std::string_view word, StampUnit unit, const std::string& where) {
  const auto stamp = parse_stamp(word, unit);
  if (!stamp)
    throw Error(fmt::format("the stamp {} is not a number of {}", in_quotes(word), unit_name(unit)), where, "");
  return *stamp;
}

SE3 pose_from(const Eigen::Quaterniond& quaternion, const Eigen::Vector3d& translation, const std::string& where) {
  const double length = quaternion.norm();
  if (!(std::abs(length - 1.0) <= quaternion_tolerance)) {
    throw Error(fmt::format("the quaternion has length {:.4g} instead of 1", length), where,
                "check the order of the columns");
  }
  return SE3(SO3(quaternion), translation);
}

Eigen::Matrix4d pose_from_rows(const std::array<double, 12>& row, const std::string& where) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 12; ++i) matrix(i / 4, i % 4) = row[static_cast<std::size_t>(i)];
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const double departure = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(departure <= rotation_tolerance) || rotation.determinant() <= 0.0) {
    throw Error(fmt::format("the 3x3 block is not a rotation (error {:.3g})", departure), where, "");
  }
  return matrix;
}

Trajectory in_order_of_time(Trajectory trajectory, std::string_view where) {
  if (trajectory.empty()) throw Error("has no poses", where, "");
  const auto earlier = [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; };
  std::stable_sort(trajectory.begin(), trajectory.end(), earlier);
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.stamp == b.stamp; };
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  return trajectory;
}

SE3 pose_of(std::span<const std::string_view> words, const TrajectoryColumns& columns, const std::string& where) {
  const auto at = [&](std::size_t column) { return number_at(words, column, where); };
  const auto& [x, y, z, w] = columns.orientation;
  const auto& [tx, ty, tz] = columns.position;
  return pose_from(Eigen::Quaterniond(at(w), at(x), at(y), at(z)), {at(tx), at(ty), at(tz)}, where);
}

/// Words of a line, separated by commas or blanks.
std::vector<std::string_view> columns(std::string_view line) {
  return line.find(',') != std::string_view::npos ? split(line, ',') : split_words(line);
}

std::vector<TimeNs> stamps_beside(const std::string& file, std::size_t pose_count) {
  const std::filesystem::path path(file);
  for (const auto& candidate :
       {path.parent_path() / (path.stem().string() + "_times.txt"), path.parent_path() / "times.txt"}) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(candidate, ignored)) continue;
    auto times = parse_kitti_times(read_text_file(candidate.string()), candidate.string());
    if (times.size() >= pose_count) return times;
  }
  std::vector<TimeNs> times(pose_count);
  for (std::size_t k = 0; k < pose_count; ++k) times[k] = static_cast<TimeNs>(k) * ns_per_second;
  return times;
}

Trajectory read_kitti(const std::string& text, const std::string& file, const std::string& times_file) {
  const auto poses = parse_kitti_poses(text, file);
  const auto times = times_file.empty() ? stamps_beside(file, poses.size())
                                        : parse_kitti_times(read_text_file(times_file), times_file);
  if (times.size() < poses.size()) {
    throw Error(fmt::format("has {} stamps for the {} poses of {}", times.size(), poses.size(), file), times_file, "");
  }
  Trajectory trajectory;
  for (std::size_t k = 0; k < poses.size(); ++k) trajectory.push_back({times[k], poses[k]});
  return in_order_of_time(std::move(trajectory), file);
}

}  // namespace

Trajectory parse_tum_trajectory(std::string_view text, std::string_view where, StampUnit unit) {
  Trajectory trajectory;
  TrajectoryColumns order = named_columns(text).value_or(tum_columns);
  if (order.last() > 7) order = tum_columns;
  for (const auto& line : content_lines(text)) {
    const auto here = at_line(where, line.number);
    const auto words = columns(line.text);
    if (words.size() != 8) {
      throw Error(fmt::format("{} columns instead of the 8 of 'stamp tx ty tz qx qy qz qw'", words.size()), here, "");
    }
    const auto stamp = stamp_at(words[0], unit, here);
    trajectory.push_back({stamp, pose_of(words, order, here)});
  }
  return in_order_of_time(std::move(trajectory), where);
}

Trajectory parse_euroc_trajectory(std::string_view text, std::string_view where, StampUnit unit) {
  Trajectory trajectory;
  const TrajectoryColumns order = named_columns(text).value_or(euroc_columns);
  for (const auto& line : content_lines(text)) {
    const auto here = at_line(where, line.number);
    const auto words = split(line.text, ',');
    if (words.size() < 8) {
      throw Error(fmt::format("{} columns instead of at least the 8 of 'stamp,px,py,pz,qw,qx,qy,qz'", words.size()),
                  here, "");
    }
    const auto stamp = stamp_at(words[0], unit, here);
    if (words.size() <= order.last())
      throw Error(fmt::format("{} columns instead of the {} that are named", words.size(), order.last() + 1), here, "");
    trajectory.push_back({stamp, pose_of(words, order, here)});
  }
  return in_order_of_time(std::move(trajectory), where);
}

std::vector<SE3> parse_kitti_poses(std::string_view text, std::string_view where) {
  std::vector<SE3> poses;
  for (const Eigen::Matrix4d& matrix : parse_kitti_matrices(text, where)) poses.push_back(SE3::from_matrix(matrix));
  return poses;
}

std::vector<Eigen::Matrix4d> parse_kitti_matrices(std::string_view text, std::string_view where) {
  std::vector<Eigen::Matrix4d> poses;
  for (const auto& line : content_lines(text)) {
    const auto here = at_line(where, line.number);
    const auto words = split_words(line.text);
    if (words.size() != 12)
      throw Error(fmt::format("{} columns instead of the 12 of a 3x4 pose", words.size()), here, "");
    std::array<double, 12> row{};
    for (std::size_t i = 0; i < 12; ++i) row[i] = number_at(words, i, here);
    poses.push_back(pose_from_rows(row, here));
  }
  if (poses.empty()) throw Error("has no poses", where, "");
  return poses;
}

std::vector<TimeNs> parse_kitti_times(std::string_view text, std::string_view where, StampUnit unit) {
  std::vector<TimeNs> times;
  for (const auto& line : content_lines(text)) {
    times.push_back(stamp_at(line.text, unit, at_line(where, line.number)));
  }
  if (times.empty()) throw Error("has no stamps", where, "");
  return times;
}

StampUnit guess_column_unit(std::string_view text, StampUnit native) {
  std::vector<double> stamps;
  for (const auto& line : content_lines(text)) {
    // The parser finds and names what is not a number.
    if (const auto stamp = parse_finite(columns(line.text).front())) stamps.push_back(*stamp);
  }
  return stamps.empty() ? native : guess_stamp_unit(stamps, native);
}

TrajectoryFormat guess_trajectory_format(std::string_view text, std::string_view where) {
  const auto lines = content_lines(text);
  if (lines.empty()) throw Error("has no poses", where, "");
  const auto& first = lines.front();
  if (first.text.find(',') != std::string_view::npos) {
    const auto words = split(first.text, ',');
    // A TUM file written with commas has a decimal point in its stamp of seconds.
    return words.size() == 8 && words[0].find('.') != std::string_view::npos ? TrajectoryFormat::tum
                                                                             : TrajectoryFormat::euroc;
  }
  const auto count = split_words(first.text).size();
  if (count == 8) return TrajectoryFormat::tum;
  if (count == 12) return TrajectoryFormat::kitti;
  throw Error(fmt::format("{} columns match no trajectory format", count), at_line(where, first.number),
              "known are TUM (8 columns), KITTI (12 columns) and EuRoC csv (8 or more columns, commas)");
}

Trajectory read_trajectory(const std::string& file, const std::string& times_file) {
  const auto text = with_commented_names(read_text_file(file));
  switch (guess_trajectory_format(text, file)) {
    case TrajectoryFormat::tum:
      return parse_tum_trajectory(text, file);
    case TrajectoryFormat::euroc:
      return parse_euroc_trajectory(text, file);
    case TrajectoryFormat::kitti:
      return read_kitti(text, file, times_file);
  }
  throw Error("is not in a known trajectory format", file, "");
}

}  // namespace rastro
