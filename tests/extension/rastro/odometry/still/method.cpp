// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/still/method.h"

namespace rastro {
namespace {

class StillOdometry : public Odometry {
 public:
  explicit StillOdometry(double height_m) : world_from_camera_(SO3(), {0.0, 0.0, height_m}) {}

  OdometryUpdate process(const Frame& frame) override {
    trajectory_.push_back({frame.stamp, world_from_camera_});
    OdometryUpdate update;
    update.index = frame.index;
    update.stamp = frame.stamp;
    update.state = OdometryState::tracking;
    update.reason = OdometryReason::no_motion;
    update.world_from_camera = world_from_camera_;
    return update;
  }
  Trajectory trajectory() const override { return trajectory_; }

 private:
  SE3 world_from_camera_;
  Trajectory trajectory_;
};

class StillOdometryMethod : public OdometryMethod {
 public:
  std::string name() const override { return "still"; }
  std::string summary() const override { return "one pose for every frame"; }
  std::string needs() const override { return "frames"; }
  OptionTable options() override {
    OptionTable table;
    table.add({"height_m", &height_m_, "m", "where the camera is held", 0, 100, {}});
    return table;
  }
  std::unique_ptr<Odometry> make(const SourceInfo&, const OdometryContext&) const override {
    return std::make_unique<StillOdometry>(height_m_);
  }

 private:
  double height_m_ = 1.5;
};

}  // namespace

std::unique_ptr<OdometryMethod> still_odometry_method() { return std::make_unique<StillOdometryMethod>(); }

}  // namespace rastro
