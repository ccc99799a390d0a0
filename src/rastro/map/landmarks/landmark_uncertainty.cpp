// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/landmark_uncertainty.h"

#include <Eigen/Dense>

#include "rastro/map/features/feature_layer.h"

namespace rastro {
namespace {

/// The constraint on the landmark along z (of the camera) from a second camera or a depth image: derivative of its
/// residual by z over its sigma; 0 if there is no such measurement.
double depth_row(const MapCamera& camera, const ImageFeatures& image, std::uint32_t feature, double z, double scale) {
  if (!(z > 0.0)) return 0.0;
  if (camera.kind == CameraKind::stereo && feature < image.right_x.size() && image.right_x[feature] >= 0.0F)
    return camera.intrinsics.fx * camera.baseline / (z * z) / scale;  // of the disparity
  if (camera.kind == CameraKind::depth && feature < image.depths.size() && image.depths[feature] > 0.0F)
    return 1.0 / camera.depth_noise.sigma(static_cast<double>(image.depths[feature]));
  return 0.0;
}

}  // namespace

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
    const MapCamera& camera = map.cameras[static_cast<std::size_t>(keyframe->camera)];
    const Eigen::Vector3d in_camera = camera_from_world * landmark.position;
    Eigen::Matrix<double, 2, 3> by_point;
    if (!camera.intrinsics.project(in_camera, by_point)) continue;
    const double scale = image->features.levels.empty() ? 1.0 : scales[image->features.levels[observation.feature]];
    const Eigen::Matrix<double, 2, 3> by_position = by_point * camera_from_world.rotation().matrix() / scale;
    information += by_position.transpose() * by_position;
    const Eigen::RowVector3d by_depth = depth_row(camera, *image, observation.feature, in_camera.z(), scale) *
                                        camera_from_world.rotation().matrix().row(2);
    information += by_depth.transpose() * by_depth;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information);
  const Eigen::Vector3d& values = solver.eigenvalues();
  if (!(values[0] > least_condition * values[2])) return std::nullopt;
  return Eigen::Matrix3d(information.inverse());
}

}  // namespace rastro
