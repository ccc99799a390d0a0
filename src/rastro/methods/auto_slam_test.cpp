// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/auto_slam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/methods/method_choice.h"
#include "rastro/methods/methods.h"

namespace rastro {
namespace {

SourceInfo camera_source(bool depth, bool right) {
  SourceInfo source;
  source.path = "recording";
  source.cameras.push_back({"cam0", Camera{}, {}, ""});
  source.has_depth = depth;
  source.has_right = right;
  return source;
}

Camera real_camera() {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 500.0, camera.cx = 319.5, camera.cy = 239.5;
  return camera;
}

SourceInfo calibrated_pair() {
  SourceInfo source = camera_source(false, true);
  source.cameras = {{"cam0", real_camera(), {}, ""}, {"cam1", real_camera(), {}, ""}};
  source.left_from_right = SE3(SO3(), {0.1, 0.0, 0.0});
  return source;
}

SourceInfo scan_source() {
  SourceInfo source;
  source.has_image = false;
  source.has_scan = source.has_odometry = true;
  return source;
}

/// Gray, with a bright square in some of the cells of 80 x 80 pixels.
GrayImage squares(int count) {
  GrayImage image(640, 480);
  for (int y = 0; y < 480; ++y) std::fill_n(image.row(y), 640, std::uint8_t{100});
  for (int i = 0; i < count; ++i)
    for (int y = 30; y < 50; ++y) std::fill_n(image.row(80 * (i / 8) + y) + 80 * (i % 8) + 30, 20, std::uint8_t{180});
  return image;
}

Frame frame_at(double seconds, int texture) {
  Frame frame;
  frame.stamp = static_cast<TimeNs>(seconds * 1e9);
  frame.image = squares(texture);
  return frame;
}

TEST(MethodChoice, TextureIsTheShareOfCellsWithCorners) {
  for (const int count : {0, 12, 48}) EXPECT_DOUBLE_EQ(texture_of(squares(count).view(), 7), count / 48.0);
  EXPECT_EQ(texture_of(squares(48).view(), 90), 0.0) << "more than the contrast of the squares";
  EXPECT_EQ(texture_of(GrayView{}, 7), 0.0);
  EXPECT_EQ(texture_of(GrayImage(20, 20).view(), 7), 0.0);
}

TEST(MethodChoice, SensorsAndTextureDecide) {
  const auto best = [](const SourceInfo& source, double texture) {
    return slam_choices(source, texture, 0.25).front().method;
  };
  EXPECT_EQ(best(camera_source(true, false), 0.5), "fusion");
  EXPECT_EQ(best(camera_source(true, false), 0.1), "rgbd");
  EXPECT_EQ(best(camera_source(false, true), 0.1), "orb") << "whose right camera is not calibrated";
  EXPECT_EQ(best(calibrated_pair(), 0.1), "fusion");
  EXPECT_EQ(slam_choices(calibrated_pair(), 0.5, 0.25, true).front().method, "orb") << "live, the faster one";
  EXPECT_EQ(slam_choices(camera_source(true, false), 0.5, 0.25, true).front().method, "orb");
  EXPECT_EQ(best(camera_source(false, false), 0.1), "orb");
  EXPECT_EQ(best(scan_source(), 0.0), "hector");
  SourceInfo robot = camera_source(true, false);
  robot.has_scan = true;
  EXPECT_EQ(best(robot, 1.0), "hector");
  SourceInfo landmarks = scan_source();
  landmarks.has_scan = false;
  landmarks.has_landmarks = true;
  EXPECT_EQ(best(landmarks, 0.0), "ekf");
  SourceInfo uncalibrated = camera_source(true, false);
  uncalibrated.cameras.front().camera.reset();
  EXPECT_THROW(best(uncalibrated, 1.0), Error);
  EXPECT_EQ(odometry_choice(camera_source(true, false)).method, "rgbd");
  EXPECT_EQ(odometry_choice(camera_source(false, true)).method, "features");
  EXPECT_THROW(odometry_choice(scan_source()), Error);
}

TEST(MethodChoice, EveryChosenMethodExists) {
  for (const SourceInfo& source : {camera_source(true, false), camera_source(false, true), scan_source()})
    for (const MethodChoice& choice : slam_choices(source, 1.0, 0.0))
      EXPECT_EQ(slam_method(choice.method)->name(), choice.method);
  EXPECT_EQ(selectable_slam_methods().front()->name(), "auto");
}

/// Gives poses, or none ever.
class FakeSlam : public Slam {
 public:
  explicit FakeSlam(bool finds_pose) : finds_pose_(finds_pose) {}
  SlamUpdate process(const Frame& frame) override {
    SlamUpdate update;
    update.stamp = frame.stamp;
    update.state = finds_pose_ ? SlamState::tracking : SlamState::initializing;
    if (finds_pose_) trajectory_.push_back({frame.stamp, SE3()});
    return update;
  }
  Trajectory trajectory() const override { return trajectory_; }
  std::shared_ptr<const Map> snapshot() const override { return nullptr; }
  void reset() override {}

 private:
  bool finds_pose_;
  Trajectory trajectory_;
};

class FakeMethod : public SlamMethod {
 public:
  FakeMethod(std::string name, bool finds_pose, std::uint64_t* seed_made_with = nullptr)
      : name_(std::move(name)), finds_pose_(finds_pose), seed_made_with_(seed_made_with) {}
  std::string name() const override { return name_; }
  std::string summary() const override { return ""; }
  std::string needs() const override { return ""; }
  OptionTable options() override {
    OptionTable table;
    if (seed_made_with_ != nullptr) table.add({"seed", &seed_, "", "seed", 0, 0, {}});
    return table;
  }
  std::unique_ptr<Slam> make(const SourceInfo&, const SlamContext&) const override {
    if (seed_made_with_ != nullptr) *seed_made_with_ = seed_;
    return std::make_unique<FakeSlam>(finds_pose_);
  }

 private:
  std::string name_;
  bool finds_pose_;
  std::uint64_t seed_ = 1;
  std::uint64_t* seed_made_with_;
};

std::string methods_in_use(const std::string& blind, int texture, double seconds) {
  const auto method =
      auto_slam_method([&](const std::string& name) { return std::make_unique<FakeMethod>(name, name != blind); });
  const auto slam = method->make(camera_source(true, false), {});
  std::string used;
  for (double at = 0.0; at <= seconds; at += 0.1) {
    for (const SlamEvent& event : slam->process(frame_at(at, texture)).events) {
      EXPECT_EQ(event.kind, "method");
      used += (used.empty() ? "" : ", ") + event.detail;
    }
  }
  return used;
}

TEST(AutoSlam, SaysWhatItChoseAndWhy) {
  EXPECT_EQ(methods_in_use("", 24, 5.0), "fusion: a depth camera, corners in 50 % of the image");
  EXPECT_EQ(methods_in_use("", 6, 5.0), "rgbd: a depth camera, corners in 12 % of the image: surfaces help");
  EXPECT_EQ(methods_in_use("rgbd", 24, 5.0), "fusion: a depth camera, corners in 50 % of the image");
}

TEST(AutoSlam, AMethodWithoutAPoseGivesWayToTheNext) {
  EXPECT_EQ(methods_in_use("fusion", 24, 1.9), "fusion: a depth camera, corners in 50 % of the image");
  EXPECT_THAT(methods_in_use("fusion", 24, 9.0), ::testing::EndsWith("image, rgbd: fusion gave no pose for 2.0 s"));
  EXPECT_THAT(methods_in_use("rgbd", 6, 9.0), ::testing::EndsWith("help, fusion: rgbd gave no pose for 2.0 s"));
}

TEST(AutoSlam, WantsWhateverItsMethodsWant) {
  const auto chooses = auto_slam_method(slam_method);
  for (const SourceInfo& source : {camera_source(true, false), camera_source(false, true), calibrated_pair()})
    for (const MethodChoice& choice : slam_choices(source, 1.0, 0.0)) {
      const auto method = slam_method(choice.method);
      EXPECT_TRUE(chooses->wants_color() || !method->wants_color()) << choice.method;
      EXPECT_TRUE(chooses->wants_depth() || !method->wants_depth()) << choice.method;
      EXPECT_TRUE(chooses->wants_right() || !method->wants_right()) << choice.method;
    }
}

TEST(AutoSlam, TheSeedIsThatOfTheMethodInUse) {
  std::uint64_t made_with = 0;
  const auto method =
      auto_slam_method([&](const std::string& name) { return std::make_unique<FakeMethod>(name, true, &made_with); });
  method->options().set("seed", "17", "a test");
  method->make(camera_source(true, false), {})->process(frame_at(0.0, 24));
  EXPECT_EQ(made_with, 17U);
}

TEST(AutoSlam, APairThatIsNotCalibratedIsUsedAsOneCamera) {
  SourceInfo pair = calibrated_pair();
  pair.left_from_right.reset();
  EXPECT_NO_THROW(slam_method("auto")->make(pair, {}));
  EXPECT_NO_THROW(slam_method("auto")->make(calibrated_pair(), {}));
  EXPECT_THROW(slam_method("fusion")->make(pair, {}), Error);
}

TEST(AutoSlam, WrongSourcesAreRefusedBeforeTheRun) {
  SourceInfo nothing;
  nothing.has_image = false;
  EXPECT_THROW(slam_method("auto")->make(nothing, {}), Error);
}

}  // namespace
}  // namespace rastro
