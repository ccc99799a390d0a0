// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_kitti.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr int frames_at_once =
    16;  // Listed in the order of time after each batch: an interrupted run is a shorter recording.

std::string numbers(const Eigen::MatrixXd& values) {
  std::string text;
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      text += fmt::format(" {:.12e}", values(row, column));
  return text;
}

/// For a camera with this baseline to the right of the first one.
Eigen::MatrixXd projection_rows(const Camera& camera, double right_m = 0.0) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, 4);
  rows << camera.fx, 0, camera.cx, -camera.fx * right_m, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0;
  return rows;
}

std::string transform_text(const SE3& transform) {
  return fmt::format("calib_time: 01-Jan-2020 00:00:00\nR:{}\nT:{}\n", numbers(transform.rotation().matrix()),
                     numbers(transform.translation().transpose()));
}

std::string date_text(TimeNs stamp) {
  const TimeNs second = 1'000'000'000;
  const std::time_t whole = static_cast<std::time_t>(stamp / second);
  return fmt::format("{:%Y-%m-%d %H:%M:%S}.{:09}", fmt::gmtime(whole), stamp % second);
}

/// Of raw data, within the folder of the output.
fs::path drive_path(TimeNs first_stamp) {
  std::string day = date_text(first_stamp).substr(0, 10);
  std::replace(day.begin(), day.end(), '-', '_');
  return fs::path(day) / (day + "_drive_0001_sync");
}

/// The lists of one layout; images are written separately, in any order.
class Lists {
 public:
  virtual ~Lists() = default;
  virtual fs::path image_of(std::int64_t frame) const = 0;
  virtual fs::path right_image_of(std::int64_t) const { return {}; }
  virtual void add(std::int64_t frame) = 0;
};

class OdometryLists : public Lists {
 public:
  OdometryLists(const World& world, const fs::path& folder, const FrameSelection& selection, bool stereo)
      : world_(world), folder_(folder), selection_(selection) {
    make_folder(folder / "image_0");
    std::string calibration = fmt::format("P0:{}\n", numbers(projection_rows(world.camera())));
    if (stereo) {
      make_folder(folder / "image_1");
      const double baseline_m = world.left_from_right()->translation().x();
      calibration += fmt::format("P1:{}\n", numbers(projection_rows(world.camera(), baseline_m)));
    }
    TextFile(folder / "calib.txt", calibration);
    times_.emplace(folder / "times.txt");
    poses_.emplace(folder / "poses.txt");
  }
  fs::path image_of(std::int64_t index) const override { return folder_ / "image_0" / fmt::format("{:06}.png", index); }
  fs::path right_image_of(std::int64_t index) const override {
    return folder_ / "image_1" / fmt::format("{:06}.png", index);
  }
  void add(std::int64_t index) override {
    const std::int64_t frame = selection_.frame(index), first = selection_.first;
    times_->write(fmt::format("{:.9e}\n", to_seconds(world_.stamp(frame) - world_.stamp(first))));
    const SE3 pose = world_.world_from_camera(first).inverse() * world_.world_from_camera(frame);
    poses_->write(numbers(pose.matrix().topRows<3>()).substr(1) + "\n");
  }

 private:
  const World& world_;
  fs::path folder_;
  FrameSelection selection_;
  std::optional<TextFile> times_, poses_;
};

class RawLists : public Lists {
 public:
  RawLists(const World& world, const fs::path& day, const fs::path& drive, const FrameSelection& selection)
      : world_(world), drive_(drive), selection_(selection) {
    make_folder(drive / "image_00/data");
    make_folder(drive / "oxts/data");
    write_calibration(day);
    image_times_.emplace(drive / "image_00/timestamps.txt");
    oxts_times_.emplace(drive / "oxts/timestamps.txt");
  }
  fs::path image_of(std::int64_t index) const override {
    return drive_ / "image_00/data" / fmt::format("{:010}.png", index);
  }
  void add(std::int64_t index) override {
    const std::int64_t frame = selection_.frame(index);
    image_times_->write(date_text(world_.stamp(frame)) + "\n");
    oxts_times_->write(date_text(world_.stamp(frame)) + "\n");
    TextFile(drive_ / "oxts/data" / fmt::format("{:010}.txt", index), oxts_line(world_, frame) + "\n");
  }

 private:
  /// The transform from the camera to the body is split into parts as in KITTI, with a laser scanner between the two
  /// and a small rotation for the rectification.
  void write_calibration(const fs::path& day) const {
    const Camera& camera = world_.camera();
    const SO3 rectified_from_camera = SO3::exp({-0.003, 0.008, 0.005});
    const SE3 scanner_from_body(SO3::exp({0.0004, -0.002, 0.0007}), {-0.81, 0.32, -0.80});
    const SE3 camera_from_scanner = SE3(rectified_from_camera, Eigen::Vector3d::Zero()).inverse() *
                                    world_.body_from_camera().inverse() * scanner_from_body.inverse();
    TextFile(day / "calib_imu_to_velo.txt", transform_text(scanner_from_body));
    TextFile(day / "calib_velo_to_cam.txt", transform_text(camera_from_scanner));
    TextFile(
        day / "calib_cam_to_cam.txt",
        fmt::format("calib_time: 01-Jan-2020 00:00:00\nS_rect_00: {} {}\nR_rect_00:{}\nP_rect_00:{}\n", camera.width,
                    camera.height, numbers(rectified_from_camera.matrix()), numbers(projection_rows(camera))));
  }

  const World& world_;
  fs::path drive_;
  FrameSelection selection_;
  std::optional<TextFile> image_times_, oxts_times_;
};

}  // namespace

KittiSummary write_kitti(const World& world, const fs::path& folder, const KittiOptions& options, TaskPool& pool,
                         const std::function<void(std::int64_t)>& progress) {
  if (options.frames < 1) throw Error("there are no frames to write", "frames", "request at least one");
  if (world.camera().distortion != Distortion::none)
    throw Error("KITTI's formats have rectified images only", world.name(), "omit the distortion");
  if (options.stereo && !(world.left_from_right() && options.layout == KittiLayout::odometry))
    throw Error("only one camera can be written", world.name(),
                "omit the options that need two, or choose a world with two and the layout of KITTI odometry");
  const bool raw = options.layout == KittiLayout::raw;
  const fs::path drive = drive_path(world.stamp(options.selection.first));
  const FolderLock lock =
      raw ? claim_folder(folder, options.force, {drive / "image_00", drive / "oxts", drive / "closures.yaml"})
          : claim_folder(folder, options.force, {"image_0", "image_1", "closures.yaml"});
  KittiSummary summary;
  summary.recording = raw ? folder / drive : folder;
  std::unique_ptr<Lists> lists;
  if (!raw) {
    lists = std::make_unique<OdometryLists>(world, folder, options.selection, options.stereo);
  } else {
    lists = std::make_unique<RawLists>(world, summary.recording.parent_path(), summary.recording, options.selection);
  }
  std::atomic<std::uintmax_t> bytes{0};
  for (std::int64_t first = 0; first < options.frames; first += frames_at_once) {
    const std::int64_t end = std::min(options.frames, first + frames_at_once);
    pool.for_chunks(0, static_cast<int>(end - first), 1, [&](int begin, int stop) {
      TaskPool alone(1);
      for (int i = begin; i < stop; ++i) {
        const std::int64_t frame = options.selection.frame(first + i);
        bytes += write_png(lists->image_of(first + i), gray_image(world.render(frame, alone).gray));
        if (options.stereo)
          bytes += write_png(lists->right_image_of(first + i), gray_image(world.render_right(frame, alone).gray));
      }
    });
    for (std::int64_t index = first; index < end; ++index) lists->add(index);
    if (progress) progress(end);
  }
  summary.frames = options.frames;
  summary.bytes = bytes;
  return summary;
}

}  // namespace rastro
