// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_errors.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/math/median.h"
#include "rastro/math/se3.h"

namespace rastro {
namespace {

constexpr std::size_t segment_step = 10;
constexpr double degrees = 180.0 / std::numbers::pi;
/// So that 1 s is reached at a stamp of 0.9999999 s and 3 steps of 0.1 m are 0.3 m.
constexpr double rounding = 1e-6;

Eigen::Vector3d position(const Eigen::Matrix4d& pose) { return pose.topRightCorner<3, 1>(); }

/// Uses the transpose, as if the rotation were exact.
Eigen::Matrix4d rigid_inverse(const Eigen::Matrix4d& pose) {
  Eigen::Matrix4d inverse = Eigen::Matrix4d::Identity();
  inverse.topLeftCorner<3, 3>() = pose.topLeftCorner<3, 3>().transpose();
  inverse.topRightCorner<3, 1>() = -inverse.topLeftCorner<3, 3>() * position(pose);
  return inverse;
}

/// The benchmark inverts whole matrices, which matters in the sixth digit with rounded rotations.
RelativeError segment_error(const PairedPoses& poses, std::size_t from, std::size_t to) {
  const Eigen::Matrix4d reference = poses.reference[from].inverse() * poses.reference[to];
  const Eigen::Matrix4d estimate = poses.estimate[from].inverse() * poses.estimate[to];
  const Eigen::Matrix4d error = estimate.inverse() * reference;
  const double cosine = 0.5 * (error.topLeftCorner<3, 3>().trace() - 1.0);
  return {position(error).norm(), std::acos(std::clamp(cosine, -1.0, 1.0))};
}

/// The measure of a delta: line numbers, seconds or meters at every pose.
std::vector<double> progress(const PairedPoses& poses, RpeDelta::Unit unit) {
  if (unit == RpeDelta::Unit::meters) return path_lengths(poses.estimate);
  std::vector<double> values;
  if (unit == RpeDelta::Unit::seconds) {
    for (const TimeNs stamp : poses.stamps) values.push_back(to_seconds(stamp - poses.stamps.front()));
  } else {
    for (std::size_t k = 0; k < poses.reference.size(); ++k) values.push_back(static_cast<double>(k));
  }
  return values;
}

}  // namespace

std::optional<ErrorStatistics> statistics_of(std::vector<double> errors) {
  if (errors.empty()) return std::nullopt;
  ErrorStatistics result;
  result.count = static_cast<int>(errors.size());
  double sum = 0.0, squares = 0.0;
  for (const double error : errors) {
    sum += error;
    squares += error * error;
  }
  result.mean = sum / result.count;
  result.rmse = std::sqrt(squares / result.count);
  const auto [least, most] = std::minmax_element(errors.begin(), errors.end());
  result.min = *least;
  result.max = *most;
  result.median = median(std::move(errors));
  return result;
}

std::vector<double> position_errors(const PairedPoses& poses) {
  std::vector<double> errors;
  for (std::size_t k = 0; k < poses.reference.size(); ++k)
    errors.push_back((position(poses.reference[k]) - position(poses.estimate[k])).norm());
  return errors;
}

std::vector<double> path_lengths(const std::vector<Eigen::Matrix4d>& poses) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < poses.size(); ++k)
    lengths.push_back(k == 0 ? 0.0 : lengths.back() + (position(poses[k]) - position(poses[k - 1])).norm());
  return lengths;
}

RpeDelta parse_rpe_delta(const std::string& text) {
  const std::string trimmed(trim(text));
  const auto unit = trimmed.empty() ? std::string::npos : std::string("fsm").find(trimmed.back());
  const auto value = unit == std::string::npos ? std::nullopt : parse_finite(trimmed.substr(0, trimmed.size() - 1));
  const bool whole = value && (unit != 0 || *value == std::floor(*value));
  if (!value || *value <= 0.0 || !whole)
    throw Error(in_quotes(text) + " is not a distance between poses", "--rpe-delta",
                "write frames, seconds or meters like 1f, 0.5s or 10m");
  return {*value, static_cast<RpeDelta::Unit>(unit)};
}

std::string as_text(const RpeDelta& delta) {
  constexpr const char* units = "fsm";
  return fmt::format("{}{}", delta.value, units[static_cast<std::size_t>(delta.unit)]);
}

RelativeError relative_error(const PairedPoses& poses, std::size_t from, std::size_t to) {
  const Eigen::Matrix4d reference = rigid_inverse(poses.reference[from]) * poses.reference[to];
  const Eigen::Matrix4d estimate = rigid_inverse(poses.estimate[from]) * poses.estimate[to];
  const Eigen::Matrix4d error = rigid_inverse(reference) * estimate;
  return {position(error).norm(), SO3::from_matrix(error.topLeftCorner<3, 3>()).log().norm()};
}

std::vector<RelativeError> relative_errors(const PairedPoses& poses, const RpeDelta& delta, bool all_pairs) {
  const std::vector<double> along = progress(poses, delta.unit);
  std::vector<RelativeError> errors;
  const auto end_of = [&](std::size_t begin, std::size_t guess) {
    while (guess < along.size() && along[guess] - along[begin] < delta.value - rounding) ++guess;
    return guess;
  };
  // As in evo, the path up to the first end only determines the first begin, if the unit is meters.
  const bool skip_first = !all_pairs && delta.unit == RpeDelta::Unit::meters;
  std::size_t begin = skip_first ? end_of(0, 1) : 0;
  for (std::size_t end = end_of(begin, begin + 1); end < along.size(); end = end_of(begin, std::max(end, begin + 1))) {
    errors.push_back(relative_error(poses, begin, end));
    begin = all_pairs ? begin + 1 : end;
  }
  return errors;
}

std::vector<SegmentErrors> segment_errors(const PairedPoses& poses, const std::vector<double>& lengths_m) {
  const std::vector<double> along = path_lengths(poses.reference);
  std::vector<SegmentErrors> all;
  for (const double length : lengths_m) {
    SegmentErrors sums{length, 0, 0.0, 0.0};
    for (std::size_t first = 0; first < along.size(); first += segment_step) {
      const auto end =
          std::upper_bound(along.begin() + static_cast<std::ptrdiff_t>(first), along.end(), along[first] + length);
      if (end == along.end()) break;
      const RelativeError error = segment_error(poses, first, static_cast<std::size_t>(end - along.begin()));
      sums.translation_percent += 100.0 * error.translation_m / length;
      sums.rotation_deg_per_m += degrees * error.rotation_rad / length;
      ++sums.count;
    }
    if (sums.count > 0) {
      sums.translation_percent /= sums.count;
      sums.rotation_deg_per_m /= sums.count;
    }
    all.push_back(sums);
  }
  return all;
}

}  // namespace rastro
