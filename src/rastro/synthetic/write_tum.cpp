// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_tum.h"

#include <fmt/format.h>

#include <atomic>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/sensor/stamp_text.h"
#include "rastro/synthetic/recording_files.h"
#include "rastro/synthetic/write_objects.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr int frames_at_once =
    16;  // Listed in the order of time after each batch: an interrupted run is a shorter recording.
constexpr std::uint64_t depth_noise = 21;

std::uint16_t raw_depth(double meters, const DepthModel& model, double normal) {
  if (!(meters >= model.nearest_m && meters <= model.farthest_m)) return 0;
  const double farther = meters - 0.4;
  const double sigma = model.sigma_m + (farther > 0.0 ? model.sigma_per_square_meter * farther * farther : 0.0);
  return static_cast<std::uint16_t>(
      std::clamp(std::round((meters + sigma * normal) * model.units_per_meter), 0.0, 65535.0));
}

cv::Mat depth_image_of(const DepthImage& depth, const DepthModel& model, Random random) {
  cv::Mat image(depth.height(), depth.width(), CV_16U);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x)
      image.at<std::uint16_t>(y, x) = raw_depth(static_cast<double>(depth.at(x, y)), model, random.normal());
  return image;
}

TimeNs depth_delay(const World& world) { return world.kinect() ? from_seconds(world.kinect()->delay_s) : 0; }

cv::Mat depth_of(const World& world, std::int64_t frame, const RenderedFrame& shot, const TumOptions& options,
                 TaskPool& pool) {
  const std::uint64_t noise = seed_for(seed_for(world.seed(), depth_noise), static_cast<std::uint64_t>(frame));
  if (!world.kinect()) return depth_image_of(shot.depth, options.depth, Random(noise));
  const double time = world.time_of(frame) + world.kinect()->delay_s;
  const Image<std::uint16_t> raw = kinect_depth(world.depth_at(time, pool), world.renderer(),
                                                world.world_from_camera_at(time), *world.kinect(), noise, pool);
  return cv::Mat(raw.height(), raw.width(), CV_16U, const_cast<std::uint16_t*>(raw.row(0)),
                 static_cast<std::size_t>(raw.stride()) * sizeof(std::uint16_t))
      .clone();
}

/// OpenCV's order is blue first.
cv::Mat color_image_of(const ColorImage& color) {
  cv::Mat image(color.height(), color.width(), CV_8UC3);
  for (int y = 0; y < color.height(); ++y) {
    const std::uint8_t* from = color.rgb.row(y);
    std::uint8_t* to = image.ptr<std::uint8_t>(y);
    for (int x = 0; x < 3 * color.width(); x += 3) to[x] = from[x + 2], to[x + 1] = from[x + 1], to[x + 2] = from[x];
  }
  return image;
}

std::string camera_text(const Camera& camera) {
  const auto& k = camera.coefficients;
  return fmt::format(
      "%YAML:1.0\nimage_width: {}\nimage_height: {}\n"
      "camera_matrix: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
      "  data: [{:.15g}, 0., {:.15g}, 0., {:.15g}, {:.15g}, 0., 0., 1.]\n"
      "distortion_coefficients: !!opencv-matrix\n  rows: 1\n  cols: 5\n  dt: d\n"
      "  data: [{:.15g}, {:.15g}, {:.15g}, {:.15g}, {:.15g}]\n"
      "calibration_error: 0.\n",
      camera.width, camera.height, camera.fx, camera.cx, camera.fy, camera.cy, k[0], k[1], k[2], k[3], k[4]);
}

std::string ground_truth_line(const World& world, std::int64_t frame) {
  const SE3 pose = world.world_from_camera(frame);
  const Eigen::Vector3d& p = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation().quaternion();
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} {:.12f}\n", seconds_text(world.stamp(frame)),
                     p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

}  // namespace

TumSummary write_tum(const World& world, const fs::path& folder, const TumOptions& options, TaskPool& pool,
                     const std::function<void(std::int64_t)>& progress) {
  if (options.frames < 1) throw Error("there are no frames to write", "frames", "request at least one");
  const FolderLock lock =
      claim_folder(folder, options.force, {"rgb", "depth", "objects.yaml", "truth.ply", "closures.yaml"});
  make_folder(folder / "rgb");
  make_folder(folder / "depth");
  TextFile(folder / "camera.yaml", camera_text(world.camera()));
  TextFile(folder / "info.txt", fmt::format("depth_factor: {:g}\n", world.kinect() ? world.kinect()->units_per_meter
                                                                                   : options.depth.units_per_meter));
  TextFile rgb(folder / "rgb.txt", "# stamp file\n"), depth(folder / "depth.txt", "# stamp file\n");
  TextFile ground_truth(folder / "groundtruth.txt", "# world_from_camera: stamp tx ty tz qx qy qz qw\n");
  const auto name_of = [&](std::int64_t frame) { return seconds_text(world.stamp(frame)) + ".png"; };
  const auto depth_stamp = [&](std::int64_t frame) { return seconds_text(world.stamp(frame) + depth_delay(world)); };
  const auto depth_name_of = [&](std::int64_t frame) { return depth_stamp(frame) + ".png"; };
  std::atomic<std::uintmax_t> bytes{0};
  if (!world.lengths().empty()) {
    TextFile(folder / "objects.yaml", objects_text(world, options.selection.first));
    bytes += write_ground_truth_mesh(world, folder / "truth.ply", options.selection.first);
  }
  const auto write_frame = [&](std::int64_t frame) {
    TaskPool alone(1);
    RenderedFrame shot = world.render(frame, alone);
    cv::Mat depth_raw = depth_of(world, frame, shot, options, alone);
    cv::Mat image = shot.color.empty() ? gray_image(shot.gray) : color_image_of(shot.color);
    if (options.black && world.time_of(frame) >= options.black->first && world.time_of(frame) < options.black->second)
      image.setTo(0), depth_raw.setTo(0);
    bytes += write_png(folder / "rgb" / name_of(frame), image);
    bytes += write_png(folder / "depth" / depth_name_of(frame), depth_raw);
  };
  for (std::int64_t first = 0; first < options.frames; first += frames_at_once) {
    const std::int64_t end = std::min(options.frames, first + frames_at_once);
    pool.for_chunks(0, static_cast<int>(end - first), 1, [&](int begin, int stop) {
      for (int i = begin; i < stop; ++i) write_frame(options.selection.frame(first + i));
    });
    for (std::int64_t index = first; index < end; ++index) {
      const std::int64_t frame = options.selection.frame(index);
      rgb.write(fmt::format("{} rgb/{}\n", seconds_text(world.stamp(frame)), name_of(frame)));
      depth.write(fmt::format("{} depth/{}\n", depth_stamp(frame), depth_name_of(frame)));
      ground_truth.write(ground_truth_line(world, frame));
    }
    if (progress) progress(end);
  }
  return {options.frames, bytes};
}

}  // namespace rastro
