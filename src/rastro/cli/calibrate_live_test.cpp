// SPDX-License-Identifier: Apache-2.0
// Live calibration of a pair and of a depth camera, from replays of generated boards whose cameras are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text_file.h"
#include "rastro/calibration/board_rendering_testing.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/cli/command.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/record/recording_writer.h"

namespace rastro::cli {
namespace {

using testing::HasSubstr;

constexpr int width = 320, height = 240;
const Board board{7, 5, 0.04};
const char* const board_flag = "chessboard:7x5:0.04";

struct Ended {
  int exit_code = 0;
  std::string out, error;
};

/// `rastro calibrate` with these words.
Ended run_calibrate(const std::vector<std::string>& words) {
  CLI::App app;
  Context context;
  add_calibrate_command(app, context);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Ended result;
  try {
    std::vector<std::string> backward(words.rbegin(), words.rend());
    backward.emplace_back("calibrate");
    app.parse(backward);
    result.exit_code = context.exit_code;
  } catch (const Error& error) {
    result.exit_code = unusable;
    result.error = error.what();
  }
  result.out = testing::internal::GetCapturedStdout();
  result.error += testing::internal::GetCapturedStderr();
  return result;
}

Lens lens_of(double focal_length) {
  Lens lens = undistorted_lens(LensModel::pinhole_4, focal_length, {158.0, 121.0});
  lens.parameters.segment<2>(4) << -0.1, 0.03;
  return lens;
}

/// Boards that are seen all over the image, near and far.
std::vector<SE3> poses_of(const Lens& lens, int count) {
  Random random(4);
  std::vector<SE3> poses;
  for (int k = 0; k < count; ++k) {
    const auto angle = [&](double degrees) { return random.uniform(-degrees, degrees) * std::numbers::pi / 180.0; };
    const SO3 rotation = SO3::exp({angle(35.0), angle(35.0), angle(12.0)});
    const double distance = random.uniform(0.5, 1.2), reach = 1.0 - 0.15 / distance;
    const Eigen::Vector2d pixel(160.0 + reach * random.uniform(-145.0, 145.0),
                                120.0 + reach * random.uniform(-100.0, 100.0));
    const Eigen::Vector2d middle = 0.5 * board.points().back();
    const Eigen::Vector3d ray = lens.unproject(pixel)->normalized();
    poses.emplace_back(rotation, ray * distance - rotation * Eigen::Vector3d(middle.x(), middle.y(), 0.0));
  }
  return poses;
}

/// Removed with the process.
class ScratchFolder {
 public:
  std::string path(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_ = scratch_folder("calibrate_live");
};

/// Depth of a board before a wall, as an exact depth camera at `camera_from_color` measures it, times `factor`.
DepthImage depth_of(const SE3& color_from_board, const Camera& camera, const SE3& color_from_depth, float factor) {
  const SE3 board_from_depth = color_from_board.inverse() * color_from_depth;
  DepthImage image(camera.width, camera.height);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const auto flat = camera.unproject({static_cast<double>(x), static_cast<double>(y)});
      const Eigen::Vector3d ray = board_from_depth.rotation() * Eigen::Vector3d(flat->x(), flat->y(), 1.0);
      const double z = -board_from_depth.translation().z() / ray.z();
      const Eigen::Vector3d hit = board_from_depth.translation() + z * ray;
      const bool on_board = z > 0.1 && hit.x() > -0.04 && hit.y() > -0.04 && hit.x() < 0.28 && hit.y() < 0.2;
      image.at(x, y) = factor * static_cast<float>(on_board ? z : 3.0);
    }
  return image;
}

/// Each board is held still for two images.
void record(const std::string& folder, const SourceInfo& info, const std::vector<SE3>& poses,
            const std::function<void(const SE3&, Frame&)>& see) {
  RecordingWriter writer(info, folder);
  TimeNs stamp = 0;
  for (const SE3& pose : poses) {
    Frame frame;
    see(pose, frame);
    for (int k = 0; k < 2; ++k) {
      frame.stamp = frame.depth_stamp = stamp += 1'000'000;
      writer.write(frame);
    }
  }
}

const SE3 right_from_left(SO3::exp({0.004, -0.01, 0.003}), {-0.06, 0.001, 0.0005});

/// `loose`: how many times as far off it may be.
void expect_pair(const std::string& file, double loose) {
  const Calibration pair = read_calibration(file);
  ASSERT_EQ(pair.cameras.size(), 2U);
  EXPECT_NEAR(pair.cameras[0].camera.fx, 260.0, 1.5 * loose);
  EXPECT_NEAR(pair.cameras[1].camera.fx, 265.0, 1.5 * loose);
  const SE3 off = *pair.cameras[1].camera_from_previous * right_from_left.inverse();
  EXPECT_LT(off.translation().norm(), 0.001 * loose);
}

TEST(CalibrateLive, APairIsCalibratedFromViewsThatBothCamerasSee) {
  const ScratchFolder folder;
  const Lens left = lens_of(260.0), right = lens_of(265.0);
  const BoardRenderer left_view(board, left, width, height), right_view(board, right, width, height);
  Random random(9);
  record(folder.path("pair"), {}, poses_of(left, 90), [&](const SE3& pose, Frame& frame) {
    frame.image = left_view.render(pose, 2.0, random);
    frame.right = right_view.render(right_from_left * pose, 2.0, random);
  });
  const Ended done = run_calibrate({"replay:" + folder.path("pair"), "--board", board_flag, "--stereo", "--model",
                                    "pinhole4", "--out", folder.path("out"), "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.error;
  expect_pair(folder.path("out/camchain.yaml"), 1.0);
  EXPECT_THAT(done.error, HasSubstr("view 20 taken"));
  EXPECT_THAT(
      run_calibrate({"replay:" + folder.path("pair"), "--board", board_flag, "--depth", "--out", folder.path("no")})
          .error,
      HasSubstr("has no depth"));
}

TEST(CalibrateLive, TwoSourcesArePairedByTheirStamps) {
  const ScratchFolder folder;
  const Lens left = lens_of(260.0), right = lens_of(265.0);
  const BoardRenderer left_view(board, left, width, height), right_view(board, right, width, height);
  Random random(9);
  RecordingWriter left_writer({}, folder.path("left")), right_writer({}, folder.path("right"));
  int missing = 0;
  TimeNs stamp = 0;
  for (const SE3& pose : poses_of(left, 36)) {
    Frame frame, beside;
    frame.image = left_view.render(pose, 2.0, random);
    beside.image = right_view.render(right_from_left * pose, 2.0, random);
    // Its own clock: a few milliseconds later, and every fifth board is lost.
    for (int k = 0; k < 2; ++k) {
      frame.stamp = stamp += 110'000'000;
      beside.stamp = stamp + 7'000'000;
      left_writer.write(frame);
      if (missing % 5 != 4) right_writer.write(beside);
    }
    ++missing;
  }
  const Ended done =
      run_calibrate({"replay:" + folder.path("left"), "--right", "replay:" + folder.path("right"), "--board",
                     board_flag, "--model", "pinhole4", "--most-views", "14", "--out", folder.path("out"), "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.error;
  expect_pair(folder.path("out/camchain.yaml"), 2.0);
}

TEST(CalibrateLive, ADepthCameraIsCalibrated) {
  const ScratchFolder folder;
  const Lens lens = lens_of(260.0);
  const Camera camera = camera_of(lens, width, height);
  const BoardRenderer view(board, lens, width, height);
  Random random(9);
  SourceInfo info;
  info.has_depth = true;
  info.depth_factor = 5000.0;
  record(folder.path("room"), info, poses_of(lens, 60), [&](const SE3& pose, Frame& frame) {
    frame.image = view.render(pose, 2.0, random);
    frame.depth = depth_of(pose, camera, {}, 0.98F);
  });
  const Ended done = run_calibrate({"replay:" + folder.path("room"), "--board", board_flag, "--depth", "--model",
                                    "pinhole4", "--out", folder.path("out"), "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.error;
  const std::string written = read_text_file(folder.path("out/camera.yaml"));
  const auto at = written.find("depth_factor: ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NEAR(std::stod(written.substr(at + 14)), 5000.0 * 0.98, 20.0) << "meters are 2 % too short";
}

TEST(CalibrateLive, DepthThatIsNotRegisteredIsPutIntoColorWithWhatWasMeasured) {
  const ScratchFolder folder;
  const Lens lens = lens_of(260.0);
  const Camera color = camera_of(lens, width, height);
  const Camera depth{160, 120, 140.0, 140.0, 79.5, 59.5};
  const SE3 color_from_depth(SO3::exp({0.01, -0.02, 0.004}), {0.05, -0.003, 0.002});
  const BoardRenderer view(board, lens, width, height);
  Random random(9);
  SourceInfo info;
  info.has_depth = true;
  info.depth_factor = 5000.0;
  const std::vector<SE3> poses = poses_of(lens, 60);
  record(folder.path("room"), info, poses, [&](const SE3& pose, Frame& frame) {
    frame.image = view.render(pose, 2.0, random);
    frame.depth = depth_of(pose, depth, color_from_depth, 1.0F);
  });
  std::ofstream(folder.path("infrared.yaml")) << "camera_matrix: [140, 0, 79.5, 0, 140, 59.5, 0, 0, 1]\n";
  const Ended done =
      run_calibrate({"replay:" + folder.path("room"), "--board", board_flag, "--depth", "--depth-camera",
                     folder.path("infrared.yaml"), "--model", "pinhole4", "--out", folder.path("out"), "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.error;
  OpenOptions options;
  options.want_depth = true;
  options.calibration_file = folder.path("out/camera.yaml");
  const auto source = open(folder.path("room"), options);
  ASSERT_TRUE(source->info().depth_registration);
  const SE3 off = source->info().depth_registration->color_from_depth * color_from_depth.inverse();
  EXPECT_LT(off.translation().norm(), 0.004);
  EXPECT_LT(off.rotation().log().norm(), 0.004);
  const DepthImage truth = depth_of(poses[0], color, {}, 1.0F), found = source->next()->depth;
  ASSERT_EQ(found.width(), width);
  int compared = 0, wrong = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      // The wall is that of either camera.
      if (found.at(x, y) == 0.0F || truth.at(x, y) > 2.5F) continue;
      ++compared;
      wrong += std::abs(found.at(x, y) - truth.at(x, y)) > 0.005F ? 1 : 0;
    }
  EXPECT_GT(compared, 5000);
  EXPECT_LT(wrong, compared / 50) << "beside the edges of the board";
}

TEST(CalibrateLive, FlagsThatDoNotGoTogetherAreAnError) {
  const std::vector<std::string> begin = {"replay:x", "--board", board_flag, "--out", "/nowhere/out"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), begin.begin(), begin.end());
    const Ended done = run_calibrate(more);
    EXPECT_EQ(done.exit_code, 2);
    return done.error;
  };
  EXPECT_THAT(with({"--right", "images"}), HasSubstr("--right"));
  EXPECT_THAT(with({"--right", "replay:y", "--stereo"}), HasSubstr("--stereo"));
  EXPECT_THAT(with({"--right", "replay:y", "--depth"}), HasSubstr("--depth"));
}

}  // namespace
}  // namespace rastro::cli
