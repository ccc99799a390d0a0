// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/map_rows.h"

#include <charconv>

#include "rastro/base/hash.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/row_parts.h"

namespace rastro {
namespace {

void put(ByteWriter& bytes, const DescribedKeypoints& features) {
  bytes.put(static_cast<std::uint32_t>(features.size()));
  for (const Keypoint& point : features.keypoints)
    for (const float value : {point.x, point.y, point.size_px, point.angle_rad, point.response}) bytes.put(value);
  bytes.put<std::int32_t>(features.length);
  bytes.put(static_cast<std::uint32_t>(features.floats.size()));
  bytes.put_raw(features.floats.data(), features.floats.size() * sizeof(float));
  bytes.put(static_cast<std::uint32_t>(features.bits.size()));
  for (const Descriptor& descriptor : features.bits) bytes.put_raw(descriptor.words.data(), sizeof descriptor.words);
}

DescribedKeypoints get_features(ByteReader& bytes) {
  DescribedKeypoints features;
  features.keypoints.resize(bytes.count(5 * sizeof(float)));
  for (Keypoint& point : features.keypoints)
    for (float* value : {&point.x, &point.y, &point.size_px, &point.angle_rad, &point.response})
      *value = bytes.get<float>();
  features.length = bytes.get<std::int32_t>();
  bytes.check(features.length >= 0);
  features.floats.resize(bytes.count(sizeof(float)));
  bytes.check(features.floats.size() == features.size() * static_cast<std::size_t>(features.length));
  for (float& value : features.floats) value = bytes.get<float>();
  features.bits.resize(bytes.count(sizeof(Descriptor::words)));
  bytes.check(features.bits.size() == (features.binary() ? features.size() : 0));
  for (Descriptor& descriptor : features.bits)
    for (std::uint64_t& word : descriptor.words) word = bytes.get<std::uint64_t>();
  return features;
}

std::vector<std::uint8_t> get_bytes(ByteReader& bytes) {
  const std::string_view piece = bytes.text();
  return {piece.begin(), piece.end()};
}

}  // namespace

const char* name_of(MapTable table) {
  constexpr const char* names[] = {"head", "keyframes", "pictures",  "poses", "edges",
                                   "way",  "contents",  "landmarks", "ties"};
  return names[static_cast<std::size_t>(table)];
}

std::span<const MapTable> tables_of(MapKind kind) {
  using enum MapTable;
  static constexpr std::array rgbd = {head, keyframes, pictures, poses, edges, way, contents};
  static constexpr std::array with_landmarks = {head, keyframes, poses, landmarks, ties, way, contents};
  return kind == MapKind::rgbd ? std::span<const MapTable>(rgbd) : std::span<const MapTable>(with_landmarks);
}

std::int64_t row_checksum(MapTable table, std::int64_t id, std::string_view body) {
  ByteWriter begin;
  begin.put_text(name_of(table));
  begin.put(id);
  Sha256 hash;
  hash.add(begin.take());
  hash.add(body);
  const std::string digits = hash.finish();
  std::uint64_t value = 0;
  std::from_chars(digits.data(), digits.data() + 16, value, 16);
  return static_cast<std::int64_t>(value);
}

std::string head_body(const RgbdMap& map) {
  ByteWriter bytes;
  bytes.put_text(map.method);
  put(bytes, map.camera);
  bytes.put(map.depth_sigma_m);
  bytes.put(map.depth_sigma_per_m2);
  return bytes.take();
}

void read_head(std::string_view body, const std::string& where, RgbdMap& map) {
  ByteReader bytes(body, where);
  map.method = bytes.text();
  map.camera = get_camera(bytes);
  map.depth_sigma_m = bytes.get<double>();
  map.depth_sigma_per_m2 = bytes.get<double>();
  bytes.finish();
}

std::string body_of(const RgbdKeyframe& keyframe) {
  ByteWriter bytes;
  bytes.put(keyframe.frame);
  bytes.put(keyframe.stamp);
  put(bytes, keyframe.features);
  bytes.put(static_cast<std::uint32_t>(keyframe.depths.size()));
  bytes.put_raw(keyframe.depths.data(), keyframe.depths.size() * sizeof(float));
  return bytes.take();
}

std::shared_ptr<const RgbdKeyframe> read_keyframe(std::string_view body, std::int64_t id, const std::string& where) {
  ByteReader bytes(body, where);
  auto keyframe = std::make_shared<RgbdKeyframe>();
  keyframe->id = id;
  keyframe->frame = bytes.get<std::int64_t>();
  keyframe->stamp = bytes.get<TimeNs>();
  keyframe->features = get_features(bytes);
  keyframe->depths.resize(bytes.count(sizeof(float)));
  bytes.check(keyframe->depths.size() == keyframe->features.size());
  for (float& depth : keyframe->depths) depth = bytes.get<float>();
  bytes.finish();
  return keyframe;
}

std::string body_of(const PackedPictures& pictures) {
  ByteWriter bytes;
  for (const auto* picture : {&pictures.colour, &pictures.depth})
    bytes.put_text({reinterpret_cast<const char*>(picture->data()), picture->size()});
  return bytes.take();
}

PackedPictures read_pictures(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  PackedPictures pictures;
  pictures.colour = get_bytes(bytes);
  pictures.depth = get_bytes(bytes);
  bytes.finish();
  return pictures;
}

std::string body_of(const KeyframePose& pose) {
  ByteWriter bytes;
  bytes.put<std::int32_t>(pose.submap);
  put(bytes, pose.world_from_camera);
  return bytes.take();
}

KeyframePose read_pose(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  KeyframePose pose;
  pose.submap = bytes.get<std::int32_t>();
  bytes.check(pose.submap >= 0);
  pose.world_from_camera = get_pose(bytes);
  bytes.finish();
  return pose;
}

std::string body_of(const PoseEdge& edge) {
  ByteWriter bytes;
  bytes.put(edge.from);
  bytes.put(edge.to);
  bytes.put(static_cast<std::uint8_t>(edge.kind));
  bytes.put(edge.weight);
  put(bytes, edge.from_from_to);
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) bytes.put(edge.information(row, column));
  return bytes.take();
}

PoseEdge read_edge(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  PoseEdge edge;
  edge.from = bytes.get<std::int64_t>();
  edge.to = bytes.get<std::int64_t>();
  const auto kind = bytes.get<std::uint8_t>();
  bytes.check(kind <= static_cast<std::uint8_t>(PoseEdgeKind::join));
  edge.kind = static_cast<PoseEdgeKind>(kind);
  edge.weight = bytes.get<double>();
  edge.from_from_to = get_pose(bytes);
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) edge.information(row, column) = bytes.get<double>();
  bytes.finish();
  return edge;
}

std::string body_of(const StampedPose& pose) {
  ByteWriter bytes;
  bytes.put(pose.stamp);
  put(bytes, pose.world_from_body);
  return bytes.take();
}

StampedPose read_stamped_pose(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  StampedPose pose;
  pose.stamp = bytes.get<TimeNs>();
  pose.world_from_body = get_pose(bytes);
  bytes.finish();
  return pose;
}

}  // namespace rastro
