// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/graph_rows.h"

#include "rastro/map/file/bytes.h"
#include "rastro/map/file/row_parts.h"

namespace rastro {
namespace {

/// No method has this name, so it differs from the heads of the first version, which begin with the method's name.
constexpr std::string_view head_mark = "map with layers";

void put(ByteWriter& bytes, const Sim3& pose) {
  bytes.put(pose.scale());
  rastro::put(bytes, pose.rotation());
  rastro::put(bytes, pose.translation());
}

Sim3 get_similarity(ByteReader& bytes) {
  const auto scale = bytes.get<double>();
  bytes.check(scale > 0.0);
  const SO3 rotation = get_rotation(bytes);
  return {scale, rotation, get_vector(bytes)};
}

bool get_flag(ByteReader& bytes) {
  const auto flag = bytes.get<std::uint8_t>();
  bytes.check(flag <= 1);
  return flag == 1;
}

}  // namespace

std::string head_body(const Map& map) {
  ByteWriter bytes;
  bytes.put_text(head_mark);
  bytes.put_text(map.method);
  bytes.put(map.revision);
  return bytes.take();
}

bool is_layered_head(std::string_view body) {
  ByteWriter mark;
  mark.put_text(head_mark);
  return body.starts_with(mark.take());
}

void read_head(std::string_view body, const std::string& where, Map& map) {
  ByteReader bytes(body, where);
  bytes.check(bytes.text() == head_mark);
  map.method = bytes.text();
  map.revision = bytes.get<std::int64_t>();
  bytes.finish();
}

std::string body_of(const MapCamera& camera) {
  ByteWriter bytes;
  bytes.put(static_cast<std::uint8_t>(camera.kind));
  put(bytes, camera.intrinsics);
  for (const double value : {camera.baseline, camera.depth_noise.sigma_m, camera.depth_noise.sigma_per_m2})
    bytes.put(value);
  put(bytes, camera.body_from_camera);
  return bytes.take();
}

MapCamera read_camera(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  MapCamera camera;
  const auto kind = bytes.get<std::uint8_t>();
  bytes.check(kind <= static_cast<std::uint8_t>(CameraKind::none));
  camera.kind = static_cast<CameraKind>(kind);
  camera.intrinsics = get_camera(bytes);
  for (double* value : {&camera.baseline, &camera.depth_noise.sigma_m, &camera.depth_noise.sigma_per_m2}) {
    *value = bytes.get<double>();
    bytes.check(*value >= 0.0);
  }
  camera.body_from_camera = get_pose(bytes);
  bytes.finish();
  return camera;
}

std::string body_of(const MapSession& session) {
  ByteWriter bytes;
  bytes.put<std::int32_t>(session.robot);
  bytes.put<std::int32_t>(session.session);
  bytes.put_text(session.recording);
  bytes.put(session.first_stamp);
  bytes.put(session.last_stamp);
  bytes.put(static_cast<std::uint8_t>(session.scale.metric));
  bytes.put(session.scale.relative_sigma);
  bytes.put_text(session.scale.origin);
  return bytes.take();
}

MapSession read_session(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  MapSession session;
  session.robot = bytes.get<std::int32_t>();
  session.session = bytes.get<std::int32_t>();
  bytes.check(session.robot >= 0 && session.session >= 0);
  session.recording = bytes.text();
  session.first_stamp = bytes.get<TimeNs>();
  session.last_stamp = bytes.get<TimeNs>();
  session.scale.metric = get_flag(bytes);
  session.scale.relative_sigma = bytes.get<double>();
  bytes.check(session.scale.relative_sigma >= 0.0);
  session.scale.origin = bytes.text();
  bytes.finish();
  return session;
}

std::string body_of(const Keyframe& keyframe) {
  ByteWriter bytes;
  bytes.put(keyframe.frame);
  bytes.put(keyframe.stamp);
  bytes.put<std::int32_t>(keyframe.camera);
  bytes.put<std::int32_t>(keyframe.submap);
  bytes.put(keyframe.parent);
  bytes.put(keyframe.weight);
  put(bytes, keyframe.world_from_camera);
  return bytes.take();
}

Keyframe read_keyframe(std::string_view body, KeyframeId id, const std::string& where) {
  ByteReader bytes(body, where);
  Keyframe keyframe;
  keyframe.id = id;
  keyframe.frame = bytes.get<std::int64_t>();
  keyframe.stamp = bytes.get<TimeNs>();
  keyframe.camera = bytes.get<std::int32_t>();
  keyframe.submap = bytes.get<std::int32_t>();
  keyframe.parent = bytes.get<KeyframeId>();
  bytes.check(keyframe.camera >= 0 && keyframe.submap >= 0 && keyframe.parent >= no_keyframe);
  keyframe.weight = bytes.get<double>();
  keyframe.world_from_camera = get_pose(bytes);
  bytes.finish();
  return keyframe;
}

std::string body_of(const Constraint& constraint) {
  ByteWriter bytes;
  bytes.put(constraint.from);
  bytes.put(constraint.to);
  bytes.put(static_cast<std::uint8_t>(constraint.kind));
  bytes.put(constraint.weight);
  bytes.put<std::int32_t>(constraint.inliers);
  put(bytes, constraint.from_from_to);
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) bytes.put(constraint.information(row, column));
  return bytes.take();
}

Constraint read_constraint(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  Constraint constraint;
  constraint.from = bytes.get<KeyframeId>();
  constraint.to = bytes.get<KeyframeId>();
  const auto kind = bytes.get<std::uint8_t>();
  bytes.check(kind < constraint_kinds);
  constraint.kind = static_cast<ConstraintKind>(kind);
  constraint.weight = bytes.get<double>();
  constraint.inliers = bytes.get<std::int32_t>();
  constraint.from_from_to = get_similarity(bytes);
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) constraint.information(row, column) = bytes.get<double>();
  bytes.finish();
  return constraint;
}

std::string body_of(const MapFrame& frame) {
  ByteWriter bytes;
  bytes.put(frame.stamp);
  bytes.put(frame.keyframe);
  put(bytes, frame.keyframe_from_camera);
  return bytes.take();
}

MapFrame read_frame(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  MapFrame frame;
  frame.stamp = bytes.get<TimeNs>();
  frame.keyframe = bytes.get<KeyframeId>();
  frame.keyframe_from_camera = get_pose(bytes);
  bytes.finish();
  return frame;
}

}  // namespace rastro
