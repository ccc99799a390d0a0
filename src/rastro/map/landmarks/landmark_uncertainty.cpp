// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/landmark_uncertainty.h"

#include <Eigen/Dense>

#include "rastro/map/features/feature_layer.h"

namespace rastro {

std::optional<Eigen::Matrix3d> landmark_covariance(const Map& map, const Landmark& landmark) {
  constexpr double least_condition = 1e-9;
  const auto features = map.layer<FeatureLayer>();
  if (!features || map.cameras.empty()) return std::nullopt;
  const std::vector<double> scales = orb_level_scales(features->extraction);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const LandmarkObservation& observation : landmark.observations) {
    const Keyframe* keyframe = map.find(observation.keyframe);
    const ImageFeatures* image = keyframe ? features->find(observation.keyframe) : nullptr;
    if (!image) continue;
    const SE3 camera_from_world = keyframe->world_from_camera.inverse();
    const Camera& camera = map.cameras[static_cast<std::size_t>(keyframe->camera)].intrinsics;
    Eigen::Matrix<double, 2, 3> by_point;
    if (!camera.project(camera_from_world * landmark.position, by_point)) continue;
    const double scale = image->features.levels.empty() ? 1.0 : scales[image->features.levels[observation.feature]];
    const Eigen::Matrix<double, 2, 3> by_position = by_point * camera_from_world.rotation().matrix() / scale;
    information += by_position.transpose() * by_position;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information);
  const Eigen::Vector3d& values = solver.eigenvalues();
  if (!(values[0] > least_condition * values[2])) return std::nullopt;
  return Eigen::Matrix3d(information.inverse());
}

}  // namespace rastro
