// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/still/method.h"

#include "rastro/map/graph/map.h"

namespace rastro {
namespace {

class StillSlam : public Slam {
 public:
  explicit StillSlam(double height_m) : world_from_body_(SO3(), {0.0, 0.0, height_m}) {}

  SlamUpdate process(const Frame& frame) override {
    trajectory_.push_back({frame.stamp, world_from_body_});
    SlamUpdate update;
    update.index = frame.index;
    update.stamp = frame.stamp;
    update.state = SlamState::tracking;
    update.world_from_body = world_from_body_;
    return update;
  }
  Trajectory trajectory() const override { return trajectory_; }
  void reset() override { trajectory_.clear(); }
  std::shared_ptr<const Map> snapshot() const override {
    auto map = std::make_shared<Map>();
    map->method = "still";
    if (trajectory_.empty()) return map;
    map->revision = 1;
    const TimeNs first = trajectory_.front().stamp, last = trajectory_.back().stamp;
    map->sessions.push_back({0, 0, "", first, last, {true, 0.0, "as set"}});
    map->keyframes.push_back({0, 0, first, 0, world_from_body_, 0, no_keyframe, 1.0});
    for (const StampedPose& pose : trajectory_) map->frames.push_back({pose.stamp, 0, SE3()});
    return map;
  }

 private:
  SE3 world_from_body_;
  Trajectory trajectory_;
};

class StillSlamMethod : public SlamMethod {
 public:
  std::string name() const override { return "still"; }
  std::string summary() const override { return "one pose for every frame"; }
  std::string needs() const override { return "frames"; }
  OptionTable options() override {
    OptionTable table;
    table.add({"height_m", &height_m_, "m", "where the robot stands", 0, 100, {}});
    return table;
  }
  std::unique_ptr<Slam> make(const SourceInfo&, const SlamContext&) const override {
    return std::make_unique<StillSlam>(height_m_);
  }

 private:
  double height_m_ = 0.5;
};

}  // namespace

std::unique_ptr<SlamMethod> still_slam_method() { return std::make_unique<StillSlamMethod>(); }

}  // namespace rastro
