// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/pose_consistency.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t numbers_of_covariance = 21;
constexpr TimeNs same_stamp_within = 1'000'000;  ///< Stamps are written with fewer digits than they have.
/// 95 % quantiles of the chi-square distribution with 1, 2 and 3 degrees of freedom.
constexpr std::array<double, 3> chi_square_95 = {3.8415, 5.9915, 7.8147};

Matrix6d covariance_in(const std::vector<std::string_view>& words, const std::string& where) {
  Matrix6d covariance;
  std::size_t next = 1;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) {
      const auto number = parse_finite(words[next++]);
      if (!number) throw Error("is not a stamp and 21 numbers", where, "give covariance_online.txt of a run");
      covariance(row, column) = covariance(column, row) = *number;
    }
  return covariance;
}

/// A squared error in units of its variance, over the directions that have one.
struct Normalized {
  double squared = 0.0;
  int freedoms = 0;
};

Normalized normalized(const Vector3d& error, const Matrix3d& covariance) {
  constexpr double smallest_share = 1e-9;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  Normalized result;
  for (int k = 0; k < 3; ++k) {
    const double variance = solver.eigenvalues()[k];
    if (!(variance > smallest_share * solver.eigenvalues()[2])) continue;
    const double along = solver.eigenvectors().col(k).dot(error);
    result.squared += along * along / variance;
    ++result.freedoms;
  }
  return result;
}

std::optional<ConsistencyOfPart> summary(const std::vector<Normalized>& errors) {
  if (errors.empty()) return std::nullopt;
  ConsistencyOfPart part;
  std::vector<double> of_limit;  // relative to the squared distance of the ellipse
  double sum = 0.0;
  for (const Normalized& error : errors) {
    of_limit.push_back(error.squared / chi_square_95[static_cast<std::size_t>(error.freedoms - 1)]);
    sum += error.squared / error.freedoms;
  }
  part.poses = static_cast<int>(errors.size());
  part.nees = sum / part.poses;
  part.inside_percent =
      100.0 * static_cast<double>(std::count_if(of_limit.begin(), of_limit.end(), [](double f) { return f <= 1.0; })) /
      part.poses;
  const auto at_95 = of_limit.begin() + static_cast<std::ptrdiff_t>(0.95 * (part.poses - 1) + 0.5);
  std::nth_element(of_limit.begin(), at_95, of_limit.end());
  part.sigma_factor = std::sqrt(*at_95);
  return part;
}

void add(std::vector<Normalized>& errors, const Normalized& error) {
  if (error.freedoms > 0 && std::isfinite(error.squared)) errors.push_back(error);
}

bool is_identity(const SE3& pose) { return pose.translation().norm() < 1e-6 && pose.rotation().log().norm() < 1e-6; }

/// Interpolated: motion within the difference of stamps must not count as an error.
std::optional<SE3> reference_at(const ConsistencyInput& input, TimeNs stamp) {
  if (input.reference.empty()) return std::nullopt;
  const TimeNs inside = std::clamp(stamp, input.reference.front().stamp, input.reference.back().stamp);
  if (std::abs(inside - stamp) > input.max_difference) return std::nullopt;
  return pose_at(input.reference, inside, 2 * input.max_difference);
}

/// Where the reference and the run are the same pose.
struct CommonOrigin {
  SE3 reference, estimate;
};

const Matrix6d* covariance_at(const std::vector<StampedCovariance>& covariances, TimeNs stamp) {
  const auto found = std::lower_bound(
      covariances.begin(), covariances.end(), stamp - same_stamp_within,
      [](const StampedCovariance& covariance, TimeNs earliest) { return covariance.stamp < earliest; });
  return found == covariances.end() || found->stamp > stamp + same_stamp_within ? nullptr : &found->covariance;
}

/// The final poses may be of a submap that was never connected to the one whose poses have covariances.
const Trajectory& poses_with_origin(const ConsistencyInput& input) {
  const bool connected = std::any_of(input.final_poses.begin(), input.final_poses.end(), [&](const StampedPose& pose) {
    return covariance_at(input.covariances, pose.stamp) != nullptr;
  });
  return connected ? input.final_poses : input.first_poses;
}

std::optional<CommonOrigin> common_origin(const ConsistencyInput& input) {
  std::optional<CommonOrigin> first;
  for (const StampedPose& pose : poses_with_origin(input)) {
    const auto reference = reference_at(input, pose.stamp);
    if (!reference) continue;
    if (is_identity(pose.world_from_body)) return CommonOrigin{*reference, pose.world_from_body};
    if (!first) first = CommonOrigin{*reference, pose.world_from_body};
  }
  return first;
}

}  // namespace

std::vector<StampedCovariance> parse_pose_covariances(std::string_view text, std::string_view where) {
  std::vector<StampedCovariance> covariances;
  for (const TextLine& line : content_lines(text)) {
    const std::string at = at_line(where, line.number);
    const auto words = split_words(line.text);
    const auto seconds = words.empty() ? std::nullopt : parse_finite(words.front());
    if (words.size() != 1 + numbers_of_covariance || !seconds || std::abs(*seconds) > 9e9)
      throw Error("is not a stamp and 21 numbers", at, "give covariance_online.txt of a run");
    covariances.push_back({from_seconds(*seconds), covariance_in(words, at)});
  }
  std::stable_sort(covariances.begin(), covariances.end(),
                   [](const StampedCovariance& a, const StampedCovariance& b) { return a.stamp < b.stamp; });
  return covariances;
}

PoseConsistency score_consistency(const ConsistencyInput& input) {
  const auto origin = common_origin(input);
  if (!origin) return {};
  std::vector<Normalized> positions, rotations;
  for (const StampedPose& pose : input.first_poses) {
    const Matrix6d* covariance = covariance_at(input.covariances, pose.stamp);
    const auto reference = reference_at(input, pose.stamp);
    if (!covariance || !reference) continue;
    const SE3 moved = origin->reference.inverse() * *reference;
    const SE3 expected = origin->estimate * SE3(moved.rotation(), moved.translation() / input.scale);
    const Vector3d position = pose.world_from_body.translation() - expected.translation();
    const Vector3d rotation = (pose.world_from_body.rotation() * expected.rotation().inverse()).log();
    add(positions, normalized(position, covariance->topLeftCorner<3, 3>()));
    add(rotations, normalized(rotation, covariance->bottomRightCorner<3, 3>()));
  }
  return {summary(positions), summary(rotations)};
}

}  // namespace rastro
