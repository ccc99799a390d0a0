// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_euroc.h"

#include <fmt/format.h>

#include <atomic>
#include <opencv2/core.hpp>

#include "rastro/base/error.h"
#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr int frames_at_once =
    16;  // Written in the order of time after each batch, so that an interrupted run is a shorter recording.

cv::Mat depth_image_of(const DepthImage& depth) {
  cv::Mat image(depth.height(), depth.width(), CV_16U);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const double meters = depth.at(x, y);
      const double steps = meters > 0.0 ? std::round(1.0 / (meters * inverse_depth_step)) : 0.0;
      image.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(std::clamp(steps, 0.0, 65535.0));
    }
  return image;
}

cv::Mat surface_image(const Image<std::uint32_t>& surface) {
  cv::Mat image(surface.height(), surface.width(), CV_16U);
  for (int y = 0; y < surface.height(); ++y)
    for (int x = 0; x < surface.width(); ++x)
      image.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(std::min<std::uint32_t>(surface.at(x, y), 65535));
  return image;
}

std::string rows_of(const Eigen::Matrix4d& m) {
  std::string text = "  data: [";
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{:.15g}, {:.15g}, {:.15g}, {:.15g}{}", row == 0 ? "" : "         ", m(row, 0), m(row, 1),
                        m(row, 2), m(row, 3), row < 3 ? ",\n" : "]\n");
  return text;
}

std::string intrinsics_text(const Camera& camera) {
  return fmt::format(
      "resolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: [{:.15g}, {:.15g}, {:.15g}, {:.15g}] #fu, fv, cu, cv\n"
      "distortion_model: radial-tangential\ndistortion_coefficients: [{:.15g}, {:.15g}, {:.15g}, {:.15g}]\n"
      "calibration_error: 0.0\n",
      camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, camera.coefficients[0],
      camera.coefficients[1], camera.coefficients[2], camera.coefficients[3]);
}

std::string camera_yaml(const World& world, const SE3& body_from_camera, double rate_hz) {
  return fmt::format(
      "# General sensor definitions.\nsensor_type: camera\ncomment: generated world '{}'\n\n"
      "# Sensor extrinsics wrt. the body-frame.\nT_BS:\n  cols: 4\n  rows: 4\n{}\n"
      "# Camera specific definitions.\nrate_hz: {:g}\n{}\n",
      world.name(), rows_of(body_from_camera.matrix()), rate_hz, intrinsics_text(world.camera()));
}

std::string ground_truth_yaml(const World& world) {
  return fmt::format(
      "%YAML:1.0\n# General sensor definitions.\nsensor_type: visual-inertial\ncomment: exact pose of the body in "
      "generated world '{}'\n\n"
      "# Sensor extrinsics wrt. the body-frame.\nT_BS:\n  cols: 4\n  rows: 4\n{}\n",
      world.name(), rows_of(Eigen::Matrix4d::Identity()));
}

constexpr const char* ground_truth_readme =
    "Exact ground truth of a generated recording: for every frame one line of camera.csv and one image of each kind.\n"
    "\n"
    "camera.csv  pose of the camera in the world (meters, Hamilton quaternion): p_in_world = q * p_in_camera + p\n"
    "camera.yaml the camera (pinhole; radial-tangential distortion) and the step of the depth images\n"
    "depth/      16-bit PNG: inverse depth along the optical axis in steps of inverse_depth_step (1/m); 0 = no "
    "surface\n"
    "surface/    16-bit PNG: index of the surface at the pixel's center; 65535 = none\n";

std::string body_line(const World& world, std::int64_t frame) {
  const SE3 world_from_body = world.world_from_camera(frame) * world.body_from_camera().inverse();
  const double time = static_cast<double>(frame) / world.rate_hz(), half = 1e-4;
  const SE3 body_inverse = world.body_from_camera().inverse();
  const Eigen::Vector3d ahead = (world.world_from_camera_at(time + half) * body_inverse).translation();
  const Eigen::Vector3d behind = (world.world_from_camera_at(time - half) * body_inverse).translation();
  const Eigen::Vector3d velocity = (ahead - behind) / (2.0 * half);
  const Eigen::Vector3d& p = world_from_body.translation();
  const Eigen::Quaterniond& q = world_from_body.rotation().quaternion();
  return fmt::format("{},{:.9f},{:.9f},{:.9f},{:.12f},{:.12f},{:.12f},{:.12f},{:.6f},{:.6f},{:.6f},0,0,0,0,0,0\n",
                     world.stamp(frame), p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), velocity.x(), velocity.y(),
                     velocity.z());
}

std::string camera_line(const World& world, std::int64_t frame) {
  const SE3 pose = world.world_from_camera(frame);
  const Eigen::Vector3d& p = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation().quaternion();
  return fmt::format("{},{:.12g},{:.12g},{:.12g},{:.15g},{:.15g},{:.15g},{:.15g}\n", world.stamp(frame), p.x(), p.y(),
                     p.z(), q.w(), q.x(), q.y(), q.z());
}

/// The list of one camera's images, with its calibration.
TextFile camera_list(const World& world, const fs::path& folder, const SE3& body_from_camera, double rate_hz) {
  make_folder(folder / "data");
  TextFile(folder / "sensor.yaml", camera_yaml(world, body_from_camera, rate_hz));
  return TextFile(folder / "data.csv", "#timestamp [ns],filename\n");
}

std::uintmax_t write_images(const World& world, const fs::path& mav, std::int64_t frame, const EurocOptions& options) {
  TaskPool alone(1);
  const RenderedFrame rendered = world.render(frame, alone);
  const std::string name = fmt::format("{}.png", world.stamp(frame));
  std::uintmax_t bytes = write_png(mav / "cam0/data" / name, gray_image(rendered.gray));
  if (options.stereo) bytes += write_png(mav / "cam1/data" / name, gray_image(world.render_right(frame, alone).gray));
  if (!options.ground_truth) return bytes;
  bytes += write_png(mav / "truth/depth" / name, depth_image_of(rendered.depth));
  bytes += write_png(mav / "truth/surface" / name, surface_image(rendered.surface));
  return bytes;
}

}  // namespace

EurocSummary write_euroc(const World& world, const fs::path& folder, const EurocOptions& options, TaskPool& pool,
                         const std::function<void(std::int64_t)>& progress) {
  if (options.frames < 1) throw Error("there are no frames to write", "frames", "request at least one");
  if (options.stereo && !world.left_from_right())
    throw Error("the world has only one camera", world.name(), "omit the options that need two");
  const FolderLock lock =
      claim_folder(folder, options.force,
                   {"mav0/cam0", "mav0/cam1", "mav0/truth", "mav0/state_groundtruth_estimate0", "closures.yaml"});
  const fs::path mav = folder / "mav0";
  make_folder(mav / "state_groundtruth_estimate0");
  TextFile(mav / "state_groundtruth_estimate0/sensor.yaml", ground_truth_yaml(world));
  const double rate_hz = world.rate_hz() / static_cast<double>(options.selection.every);
  TextFile images = camera_list(world, mav / "cam0", world.body_from_camera(), rate_hz);
  std::optional<TextFile> right;
  if (options.stereo)
    right = camera_list(world, mav / "cam1", world.body_from_camera() * *world.left_from_right(), rate_hz);
  TextFile poses(mav / "state_groundtruth_estimate0/data.csv",
                 "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z "
                 "[],v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],"
                 "v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m "
                 "s^-2],b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]\n");
  std::optional<TextFile> cameras;
  if (options.ground_truth) {
    make_folder(mav / "truth/depth");
    make_folder(mav / "truth/surface");
    TextFile(mav / "truth/README", ground_truth_readme);
    TextFile(mav / "truth/camera.yaml",
             fmt::format("{}inverse_depth_step: {:.17g}\n", intrinsics_text(world.camera()), inverse_depth_step));
    cameras.emplace(mav / "truth/camera.csv", "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n");
  }
  EurocSummary summary;
  std::atomic<std::uintmax_t> bytes{0};
  for (std::int64_t first = 0; first < options.frames; first += frames_at_once) {
    const std::int64_t end = std::min(options.frames, first + frames_at_once);
    pool.for_chunks(0, static_cast<int>(end - first), 1, [&](int begin, int stop) {
      for (int i = begin; i < stop; ++i) bytes += write_images(world, mav, options.selection.frame(first + i), options);
    });
    for (std::int64_t index = first; index < end; ++index) {
      const std::int64_t frame = options.selection.frame(index);
      images.write(fmt::format("{0},{0}.png\n", world.stamp(frame)));
      if (right) right->write(fmt::format("{0},{0}.png\n", world.stamp(frame)));
      poses.write(body_line(world, frame));
      if (cameras) cameras->write(camera_line(world, frame));
    }
    if (progress) progress(end);
  }
  summary.frames = options.frames;
  summary.bytes = bytes;
  return summary;
}

}  // namespace rastro
