// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/mcap/foxglove_messages.h"
#if RASTRO_WITH_MCAP
#include <algorithm>

#include "rastro/base/text.h"
#include "rastro/export/mcap/foxglove_parts.h"
#include "rastro/export/raw_bytes.h"

namespace rastro::detail {
namespace {

using foxglove::PackedElementField;

template <typename Message>
void add_field(const char* name, std::uint32_t offset, PackedElementField::NumericType type, Message& message) {
  PackedElementField& field = *message.add_fields();
  field.set_name(name);
  field.set_offset(offset);
  field.set_type(type);
}

/// Adds the fields of a point; returns the bytes that it takes.
std::uint32_t add_point_fields(const McapRun::Points& points, foxglove::PointCloud& message) {
  std::uint32_t bytes = 0;
  for (const char* name : {"x", "y", "z"}) {
    add_field(name, bytes, PackedElementField::FLOAT32, message);
    bytes += sizeof(float);
  }
  if (!points.colors.empty())
    for (const char* name : {"red", "green", "blue", "alpha"})
      add_field(name, bytes++, PackedElementField::UINT8, message);
  if (points.sigmas.empty()) return bytes;
  add_field("sigma", bytes, PackedElementField::FLOAT32, message);
  return bytes + sizeof(float);
}

std::string packed_points(const McapRun::Points& points, std::uint32_t stride) {
  constexpr char opaque = '\xff';
  const std::size_t count = points.positions.size() / 3;
  std::string bytes;
  bytes.reserve(count * stride);
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_raw(bytes, points.positions[3 * k + axis]);
    if (!points.colors.empty()) {
      for (std::size_t channel = 0; channel < 3; ++channel) append_raw(bytes, points.colors[3 * k + channel]);
      bytes += opaque;
    }
    if (!points.sigmas.empty()) append_raw(bytes, points.sigmas[k]);
  }
  return bytes;
}

const char* model_of(Distortion distortion) {
  if (distortion == Distortion::rational) return "rational_polynomial";
  return distortion == Distortion::equidistant ? "kannala_brandt" : "plumb_bob";
}

foxglove::Log::Level level_of(McapRun::Level level) {
  switch (level) {
    case McapRun::Level::info:
      return foxglove::Log::INFO;
    case McapRun::Level::warning:
      return foxglove::Log::WARNING;
    case McapRun::Level::error:
      return foxglove::Log::ERROR;
  }
  return foxglove::Log::UNKNOWN;
}

}  // namespace

const char* moving_frame(const McapRun& run) { return run.of_camera ? "camera" : "body"; }

std::string pose_message(TimeNs time, const SE3& pose) {
  foxglove::PoseInFrame message;
  set_time(time, *message.mutable_timestamp());
  message.set_frame_id(world_frame);
  set_pose(pose, *message.mutable_pose());
  return bytes_of_message(message);
}

std::string poses_message(TimeNs time, const Trajectory& trajectory) {
  foxglove::PosesInFrame message;
  set_time(time, *message.mutable_timestamp());
  message.set_frame_id(world_frame);
  for (const StampedPose& pose : trajectory) set_pose(pose.world_from_body, *message.add_poses());
  return bytes_of_message(message);
}

std::string transform_message(TimeNs time, const McapRun& run, const SE3& world_from_body) {
  foxglove::FrameTransform message;
  set_time(time, *message.mutable_timestamp());
  message.set_parent_frame_id(world_frame);
  message.set_child_frame_id(moving_frame(run));
  set_vector(world_from_body.translation(), *message.mutable_translation());
  set_quaternion(world_from_body.rotation().quaternion(), *message.mutable_rotation());
  return bytes_of_message(message);
}

std::string upright_message(TimeNs time, const Eigen::Vector3d& up) {
  foxglove::FrameTransform message;
  set_time(time, *message.mutable_timestamp());
  message.set_parent_frame_id(upright_frame);
  message.set_child_frame_id(world_frame);
  set_vector(Eigen::Vector3d::Zero(), *message.mutable_translation());
  set_quaternion(Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()), *message.mutable_rotation());
  return bytes_of_message(message);
}

std::string points_message(TimeNs time, const McapRun::Points& points) {
  foxglove::PointCloud message;
  set_time(time, *message.mutable_timestamp());
  message.set_frame_id(world_frame);
  set_pose(SE3(), *message.mutable_pose());
  message.set_point_stride(add_point_fields(points, message));
  message.set_data(packed_points(points, message.point_stride()));
  return bytes_of_message(message);
}

std::string grid_message(TimeNs time, const McapRun::Grid& grid) {
  foxglove::Grid message;
  set_time(time, *message.mutable_timestamp());
  message.set_frame_id(world_frame);
  set_pose(SE3(SO3(), {grid.origin[0], grid.origin[1], 0.0}), *message.mutable_pose());
  message.set_column_count(static_cast<std::uint32_t>(grid.width));
  message.mutable_cell_size()->set_x(grid.cell);
  message.mutable_cell_size()->set_y(grid.cell);
  message.set_row_stride(static_cast<std::uint32_t>(grid.width));
  message.set_cell_stride(1);
  add_field("occupancy", 0, PackedElementField::UINT8, message);
  message.set_data(std::string(grid.cells.begin(), grid.cells.end()));
  return bytes_of_message(message);
}

std::string image_message(TimeNs time, const McapRun& run, const std::string& jpeg) {
  foxglove::CompressedImage message;
  set_time(time, *message.mutable_timestamp());
  message.set_frame_id(moving_frame(run));
  message.set_data(jpeg);
  message.set_format("jpeg");
  return bytes_of_message(message);
}

std::string calibration_message(TimeNs time, const McapRun& run) {
  RASTRO_CHECK(run.camera.has_value(), "a calibration is of a camera");
  const Camera& camera = *run.camera;
  foxglove::CameraCalibration message;
  set_time(time, *message.mutable_timestamp());
  message.set_frame_id(moving_frame(run));
  message.set_width(static_cast<std::uint32_t>(camera.width));
  message.set_height(static_cast<std::uint32_t>(camera.height));
  message.set_distortion_model(model_of(camera.distortion));
  const std::size_t coefficients =
      camera.distortion == Distortion::equidistant ? 4 : std::max<std::size_t>(5, camera.coefficient_count());
  for (std::size_t k = 0; k < coefficients; ++k) message.add_d(camera.coefficients[k]);
  for (const double each : {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0}) message.add_k(each);
  for (const double each : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) message.add_r(each);
  for (const double each : {camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0})
    message.add_p(each);
  return bytes_of_message(message);
}

std::string log_message(const McapRun::Note& note) {
  constexpr std::size_t longest = 1000;
  foxglove::Log message;
  set_time(note.stamp, *message.mutable_timestamp());
  message.set_level(level_of(note.level));
  message.set_name(one_line(note.kind));
  message.set_message(one_line(note.text.empty() ? note.kind : note.kind + ": " + note.text, longest));
  return bytes_of_message(message);
}

}  // namespace rastro::detail
#endif
