// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/initial_pose.h"

#include <cmath>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

void check_finite(const SE3& pose) {
  if (pose.translation().allFinite() && pose.rotation().quaternion().coeffs().allFinite()) return;
  throw Error("is not finite", "the initial pose", "give finite meters and radians");
}

Matrix6d rotated(const Matrix6d& covariance, const SO3& rotation) {
  Matrix6d by = Matrix6d::Zero();
  by.topLeftCorner<3, 3>() = by.bottomRightCorner<3, 3>() = rotation.matrix();
  const Matrix6d result = by * covariance * by.transpose();
  return 0.5 * (result + result.transpose());
}

std::shared_ptr<const LandmarkLayer> transformed(const LandmarkLayer& layer, const SE3& new_world_from_world) {
  auto result = std::make_shared<LandmarkLayer>(layer);
  const Eigen::Matrix3d rotation = new_world_from_world.rotation().matrix();
  for (Landmark& landmark : result->landmarks) {
    landmark.position = new_world_from_world * landmark.position;
    landmark.direction = rotation * landmark.direction;
  }
  for (LandmarkEstimate& estimate : result->estimates) {
    const Eigen::Matrix3d covariance = rotation * estimate.covariance * rotation.transpose();
    estimate.covariance = 0.5 * (covariance + covariance.transpose());
  }
  return result;
}

class TransformedArchive : public MapArchive {
 public:
  TransformedArchive(MapArchive& archive, const SE3& initial_pose) : archive_(archive), initial_pose_(initial_pose) {}
  bool wants_map() const override { return archive_.wants_map(); }
  void keep(std::shared_ptr<const Map> map) override {
    archive_.keep(map ? std::make_shared<const Map>(transformed(*map, initial_pose_)) : map);
  }
  void add_images(KeyframeId keyframe, PackedImages images) override {
    archive_.add_images(keyframe, std::move(images));
  }
  std::shared_ptr<const ImageStore> images() const override { return archive_.images(); }
  void add_row(const std::string& layer, KeyframeId keyframe, const std::string& body) override {
    archive_.add_row(layer, keyframe, body);
  }
  std::shared_ptr<const RowStore> rows(const std::string& layer) const override { return archive_.rows(layer); }

 private:
  MapArchive& archive_;
  SE3 initial_pose_;
};

class TransformedSlam : public Slam {
 public:
  TransformedSlam(const SlamContext& context, const SlamMaker& make) : initial_pose_(*context.initial_pose) {
    SlamContext own = context;
    own.initial_pose.reset();
    if (context.archive != nullptr) {
      archive_ = std::make_unique<TransformedArchive>(*context.archive, initial_pose_);
      own.archive = archive_.get();
    }
    method_ = make(own);
  }

  SlamUpdate process(const Frame& frame) override {
    SlamUpdate update = method_->process(frame);
    update.world_from_body = initial_pose_ * update.world_from_body;
    if (update.covariance) update.covariance = rotated(*update.covariance, initial_pose_.rotation());
    return update;
  }
  std::vector<SlamEvent> finish() override { return method_->finish(); }
  Trajectory trajectory() const override {
    Trajectory trajectory = method_->trajectory();
    for (StampedPose& pose : trajectory) pose.world_from_body = initial_pose_ * pose.world_from_body;
    return trajectory;
  }
  std::shared_ptr<const Map> snapshot() const override {
    const auto map = method_->snapshot();
    return map ? std::make_shared<const Map>(transformed(*map, initial_pose_)) : map;
  }
  std::vector<PlaceBelief> places() const override { return method_->places(); }
  void reset() override { method_->reset(); }
  bool set_mapping(bool on) override { return method_->set_mapping(on); }
  std::vector<FeatureObservation> observations() const override { return method_->observations(); }
  std::int64_t dropped_frames() const override { return method_->dropped_frames(); }
  MapMemory map_memory() const override { return method_->map_memory(); }

 private:
  SE3 initial_pose_;
  std::unique_ptr<TransformedArchive> archive_;  ///< Null if there is none. Outlives the method.
  std::unique_ptr<Slam> method_;
};

}  // namespace

std::unique_ptr<Slam> make_with_initial_pose(const SlamContext& context, const SlamMaker& make) {
  if (!context.initial_pose) return make(context);
  check_finite(*context.initial_pose);
  if (context.map) return make(context);
  return std::make_unique<TransformedSlam>(context, make);
}

SE2 planar_initial_pose(const SlamContext& context, const std::string& method) {
  if (!context.initial_pose) return {};
  const SE3& pose = *context.initial_pose;
  check_finite(pose);
  const Eigen::Matrix3d rotation = pose.rotation().matrix();
  constexpr double most = 1e-9;
  if (std::abs(pose.translation().z()) > most || std::abs(rotation(2, 2) - 1.0) > most)
    throw Error("has z, roll or pitch, and the method " + method + " is planar", "the initial pose",
                "give x, y and yaw");
  return {SO2::from_angle(std::atan2(rotation(1, 0), rotation(0, 0))), pose.translation().head<2>()};
}

Map transformed(const Map& map, const SE3& new_world_from_world) {
  Map result = map;
  for (Keyframe& keyframe : result.keyframes)
    keyframe.world_from_camera = new_world_from_world * keyframe.world_from_camera;
  if (const auto landmarks = map.layer<LandmarkLayer>())
    result.layers.put<LandmarkLayer>(transformed(*landmarks, new_world_from_world));
  return result;
}

}  // namespace rastro
