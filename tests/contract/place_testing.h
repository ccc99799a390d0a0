// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "rastro/map/images/room_map_testing.h"
#include "rastro/sensor/source.h"
#include "rastro/slam/slam_method.h"
#include "rastro/synthetic/worlds/loop.h"
#include "room_testing.h"

namespace rastro {

/// A generated recording with ground truth, of a kind that some methods can use.
class TestRecording {
 public:
  virtual ~TestRecording() = default;
  virtual int frame_count() const = 0;
  /// Frames of a drive that revisits places.
  virtual int long_count() const = 0;
  virtual SourceInfo info() const = 0;
  virtual Frame frame(int number) const = 0;
  virtual TimeNs stamp(int number) const = 0;
  virtual SE3 world_from_body(int number) const = 0;
  /// Maximum distance of a pose from the first.
  virtual double reach_m() const = 0;
  /// False: up to scale.
  virtual bool is_metric() const { return true; }

  std::vector<Frame> frames(int count) const {
    std::vector<Frame> frames;
    for (int k = 0; k < count; ++k) frames.push_back(frame(k));
    return frames;
  }
  std::vector<Frame> frames() const { return frames(frame_count()); }
  TimeNs step() const { return stamp(1) - stamp(0); }
};

/// Recorded with a laser and wheel odometry.
class LaserRecording : public TestRecording {
 public:
  int frame_count() const override { return Room::frame_count; }
  int long_count() const override { return 600; }  // nearly three times around
  SourceInfo info() const override { return Room::info(); }
  Frame frame(int number) const override { return Room::frame(number); }
  TimeNs stamp(int number) const override { return Room::stamp(number); }
  SE3 world_from_body(int number) const override {
    const SE2 pose = Room::world_from_body(number);
    return {SO3::exp(pose.rotation().angle() * Eigen::Vector3d::UnitZ()),
            {pose.translation().x(), pose.translation().y(), 0.0}};
  }
  double reach_m() const override { return 2.0 * Room::radius_m; }
};

/// Recorded with a hand-held depth camera that swings to and fro.
class DepthRecording : public TestRecording {
 public:
  static constexpr int swing = 48;  ///< Frames of one rotation there and back.

  int frame_count() const override { return 48; }
  int long_count() const override { return 100; }
  SourceInfo info() const override {
    SourceInfo info;
    info.path = "depth room";
    info.format = "generated";
    info.frame_count = frame_count();
    info.has_depth = true;
    info.cameras.push_back({"rgb", camera(), std::nullopt, "generated"});
    return info;
  }
  Frame frame(int number) const override {
    // The same at every swing but for its stamp, so that each image is made once.
    static std::map<int, Frame> made;
    const int index = number % swing;
    if (!made.contains(index)) made[index] = test_room::frame_from(world_from_body(index), camera());
    Frame frame = made[index];
    frame.index = number;
    frame.stamp = frame.depth_stamp = stamp(number);
    frame.name = std::to_string(number);
    return frame;
  }
  TimeNs stamp(int number) const override { return 1'000 * ns_per_second + number * (ns_per_second / 30); }
  SE3 world_from_body(int number) const override {
    const double phase = 2.0 * M_PI * (number % swing) / swing;
    const SE3 middle = test_room::world_from_camera(1, 3);
    return middle * SE3(SO3::exp({0.12 * std::sin(2.0 * phase), 0.3 * std::sin(phase), 0.05 * std::sin(phase)}),
                        {0.25 * std::sin(phase), 0.06 * std::sin(2.0 * phase), 0.2 * (1.0 - std::cos(phase))});
  }
  double reach_m() const override { return 0.6; }

 private:
  static Camera camera() { return test_room::camera().scaled(0.75); }
};

/// A square recorded with one camera or two, looking sideways, on a walk along it, to and fro.
class CameraRecording : public TestRecording {
 public:
  static constexpr int first = 748, there = 48;  ///< Frames of the loop that are shown, then the same backwards.

  explicit CameraRecording(bool stereo) : stereo_(stereo) {}
  int frame_count() const override { return there; }
  int long_count() const override { return there + 24; }
  SourceInfo info() const override {
    SourceInfo info;
    info.path = "square";
    info.format = "generated";
    info.frame_count = frame_count();
    info.cameras.push_back({"cam0", world().camera(), std::nullopt, "generated"});
    if (!stereo_) return info;
    info.cameras.push_back({"cam1", world().camera(), std::nullopt, "generated"});
    info.has_right = true;
    info.left_from_right = world().left_from_right();
    return info;
  }
  Frame frame(int number) const override {
    static std::map<int, Frame> made;
    const int index = index_of(number);
    if (!made.contains(index)) {
      TaskPool alone(1);
      made[index].image = world().render(index, alone).gray;
      made[index].right = world().render_right(index, alone).gray;
    }
    Frame frame = made[index];
    if (!stereo_) frame.right = {};
    frame.index = number;
    frame.stamp = stamp(number);
    frame.name = std::to_string(number);
    return frame;
  }
  TimeNs stamp(int number) const override { return 1'000 * ns_per_second + number * (ns_per_second / 20); }
  SE3 world_from_body(int number) const override { return world().world_from_camera(index_of(number)); }
  double reach_m() const override { return stereo_ ? 5.0 : 1e3; }
  bool is_metric() const override { return stereo_; }

 private:
  static int index_of(int number) {
    const int within = number % (2 * there - 2);
    return first + (within < there ? within : 2 * there - 2 - within);
  }
  static const World& world() {
    static const World world = make_loop({.scale = 0.5, .threads = 2});
    return world;
  }

  bool stereo_;
};

/// The kind of recording that a method is made for; `sensor` where it takes several.
inline std::unique_ptr<TestRecording> recording_for(const SlamMethod& method, const std::string& sensor) {
  if (sensor == "mono" || sensor == "stereo") return std::make_unique<CameraRecording>(sensor == "stereo");
  if (method.wants_depth()) return std::make_unique<DepthRecording>();
  if (!method.is_planar()) return std::make_unique<CameraRecording>(false);
  return std::make_unique<LaserRecording>();
}

}  // namespace rastro
