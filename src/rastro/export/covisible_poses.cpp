// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/covisible_poses.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace rastro {

/// A landmark that two keyframes share.
struct CovisiblePoses::Pixel {
  Eigen::Vector3d in_first = Eigen::Vector3d::Zero();
  Eigen::Vector2d in_second = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;
};

namespace {

constexpr std::size_t fewest_landmarks = 10;
constexpr double huber = 2.0;              ///< Sigmas.
constexpr double least_condition = 1e-12;  ///< Of the information; its units differ.

/// One linear system of the pose: ground truth = first_from_second * exp(d).
struct Normal {
  Matrix6d information = Matrix6d::Zero();
  Vector6d right = Vector6d::Zero();
};

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

template <typename Pixels>
Normal normal_at(const Camera& camera, const Pixels& pixels, const SE3& first_from_second) {
  Normal normal;
  const SE3 second_from_first = first_from_second.inverse();
  for (const auto& pixel : pixels) {
    const Eigen::Vector3d point = second_from_first * pixel.in_first;
    Eigen::Matrix<double, 2, 3> by_point;
    const auto projected = camera.project(point, by_point);
    if (!projected) continue;
    const Eigen::Vector2d residual = (pixel.in_second - *projected) / pixel.sigma_px;
    Eigen::Matrix<double, 3, 6> by_step;
    by_step << -Eigen::Matrix3d::Identity(), cross(point);
    const Eigen::Matrix<double, 2, 6> jacobian = by_point * by_step / pixel.sigma_px;
    const double norm = residual.norm(), weight = norm > huber ? huber / norm : 1.0;
    normal.information += weight * jacobian.transpose() * jacobian;
    normal.right += weight * jacobian.transpose() * residual;
  }
  return normal;
}

bool holds_pose(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0] > least_condition * solver.eigenvalues()[5];
}

}  // namespace

CovisiblePoses::CovisiblePoses(const Map& map, int submap)
    : map_(map), part_(map, submap), observed_(map.keyframes.size()) {
  const std::vector<Landmark>& landmarks = part_.landmarks();
  for (std::size_t k = 0; k < landmarks.size(); ++k)
    for (const LandmarkObservation& observation : landmarks[k].observations)
      if (const auto index = part_.index_of(observation.keyframe); index && part_.keypoint_of(observation))
        observed_[*index].push_back({k, observation.feature});
}

std::vector<CovisiblePoses::Pixel> CovisiblePoses::shared(std::size_t first, std::size_t second) const {
  const SE3 first_from_world = map_.keyframes[first].world_from_camera.inverse();
  const ImageFeatures& features = *part_.features_of(map_.keyframes[second].id);
  const std::vector<double> scales = orb_level_scales(map_.layer<FeatureLayer>()->extraction);
  std::vector<Pixel> pixels;
  auto at = observed_[first].begin();
  for (const Observed& seen : observed_[second]) {
    while (at != observed_[first].end() && at->landmark < seen.landmark) ++at;
    if (at == observed_[first].end()) break;
    if (at->landmark != seen.landmark) continue;
    const Keypoint& keypoint = features.features.keypoints[seen.feature];
    const double sigma = features.features.levels.empty() ? 1.0 : scales[features.features.levels[seen.feature]];
    pixels.push_back({first_from_world * part_.landmarks()[seen.landmark].position,
                      {static_cast<double>(keypoint.x), static_cast<double>(keypoint.y)},
                      sigma});
  }
  return pixels;
}

std::optional<CovisiblePose> CovisiblePoses::fitted(std::size_t first, std::size_t second, SE3 pose,
                                                    int most_steps) const {
  constexpr double small_step = 1e-10;
  if (observed_[first].size() < fewest_landmarks || observed_[second].size() < fewest_landmarks) return std::nullopt;
  const std::vector<Pixel> pixels = shared(first, second);
  if (pixels.size() < fewest_landmarks) return std::nullopt;
  const Camera& camera = map_.cameras[static_cast<std::size_t>(map_.keyframes[second].camera)].intrinsics;
  Normal normal = normal_at(camera, pixels, pose);
  for (int step = 0; step < most_steps && holds_pose(normal.information); ++step) {
    const Vector6d change = normal.information.ldlt().solve(normal.right);
    pose = pose * SE3::exp(change);
    normal = normal_at(camera, pixels, pose);
    if (change.norm() < small_step * (1.0 + pose.translation().norm())) break;
  }
  if (!holds_pose(normal.information) || !pose.translation().allFinite()) return std::nullopt;
  return CovisiblePose{pose, normal.information};
}

std::optional<CovisiblePose> CovisiblePoses::measure(std::size_t first, std::size_t second) const {
  constexpr int most_steps = 20;
  const SE3 start = map_.keyframes[first].world_from_camera.inverse() * map_.keyframes[second].world_from_camera;
  return fitted(first, second, start, most_steps);
}

std::optional<CovisiblePose> CovisiblePoses::judge(std::size_t first, std::size_t second,
                                                   const SE3& first_from_second) const {
  return fitted(first, second, first_from_second, 0);
}

}  // namespace rastro
