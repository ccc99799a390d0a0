// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/landmark_rows.h"

#include "rastro/map/file/row_parts.h"

namespace rastro {
namespace {

/// No method has this name, with which the head of a map of a depth camera begins.
constexpr std::string_view head_mark = "map of landmarks";

void put(ByteWriter& bytes, const Eigen::Vector3d& vector) {
  for (int i = 0; i < 3; ++i) bytes.put(vector[i]);
}

Eigen::Vector3d get_vector(ByteReader& bytes) {
  Eigen::Vector3d vector;
  for (double& value : vector) value = bytes.get<double>();
  return vector;
}

void put(ByteWriter& bytes, const OrbFeatures& features) {
  static_assert(sizeof(Keypoint) == 5 * sizeof(float) && sizeof(Descriptor) == 32);
  bytes.put(static_cast<std::uint32_t>(features.size()));
  bytes.put_raw(features.keypoints.data(), features.size() * sizeof(Keypoint));
  bytes.put_raw(features.levels.data(), features.size());
  bytes.put_raw(features.descriptors.data(), features.size() * sizeof(Descriptor));
}

OrbFeatures get_features(ByteReader& bytes) {
  OrbFeatures features;
  const std::size_t count = bytes.count(sizeof(Keypoint) + 1 + sizeof(Descriptor));
  features.keypoints.resize(count);
  for (Keypoint& point : features.keypoints)
    for (float* value : {&point.x, &point.y, &point.size_px, &point.angle_rad, &point.response})
      *value = bytes.get<float>();
  const std::string_view levels = bytes.raw(count);
  features.levels.assign(levels.begin(), levels.end());
  features.descriptors.resize(count);
  const std::string_view descriptors = bytes.raw(count * sizeof(Descriptor));
  if (count > 0) std::memcpy(features.descriptors.data(), descriptors.data(), descriptors.size());
  return features;
}

void put(ByteWriter& bytes, const std::vector<float>& values) {
  bytes.put(static_cast<std::uint32_t>(values.size()));
  bytes.put_raw(values.data(), values.size() * sizeof(float));
}

/// One for each of `features`, or none.
std::vector<float> get_floats(ByteReader& bytes, std::size_t features) {
  std::vector<float> values(bytes.count(sizeof(float)));
  bytes.check(values.empty() || values.size() == features);
  for (float& value : values) value = bytes.get<float>();
  return values;
}

void put(ByteWriter& bytes, const OrbOptions& options) {
  for (const int value : {options.features, options.levels, options.fast_threshold, options.least_fast_threshold})
    bytes.put<std::int32_t>(value);
  bytes.put(options.scale_factor);
}

OrbOptions get_orb_options(ByteReader& bytes) {
  constexpr int most_levels = 32;
  OrbOptions options;
  for (int* value : {&options.features, &options.levels, &options.fast_threshold, &options.least_fast_threshold}) {
    *value = bytes.get<std::int32_t>();
    bytes.check(*value >= 0);
  }
  options.scale_factor = bytes.get<double>();
  bytes.check(options.levels >= 1 && options.levels <= most_levels);
  bytes.check(options.scale_factor >= 1.0 && options.scale_factor <= 4.0);
  return options;
}

}  // namespace

std::string head_body(const LandmarkMap& map) {
  ByteWriter bytes;
  bytes.put_text(head_mark);
  bytes.put_text(map.method);
  bytes.put(static_cast<std::uint8_t>(map.sensor));
  put(bytes, map.camera);
  bytes.put(map.baseline);
  bytes.put(static_cast<std::uint8_t>(map.scale.metric));
  bytes.put(map.scale.relative_sigma);
  bytes.put_text(map.scale.origin);
  put(bytes, map.features);
  return bytes.take();
}

bool is_landmark_head(std::string_view body) {
  ByteWriter mark;
  mark.put_text(head_mark);
  return body.starts_with(mark.take());
}

void read_head(std::string_view body, const std::string& where, LandmarkMap& map) {
  ByteReader bytes(body, where);
  bytes.check(bytes.text() == head_mark);
  map.method = bytes.text();
  const auto sensor = bytes.get<std::uint8_t>();
  bytes.check(sensor <= static_cast<std::uint8_t>(LandmarkSensor::rgbd));
  map.sensor = static_cast<LandmarkSensor>(sensor);
  map.camera = get_camera(bytes);
  map.baseline = bytes.get<double>();
  bytes.check(map.baseline >= 0.0);
  const auto metric = bytes.get<std::uint8_t>();
  bytes.check(metric <= 1);
  map.scale.metric = metric == 1;
  map.scale.relative_sigma = bytes.get<double>();
  bytes.check(map.scale.relative_sigma >= 0.0);
  map.scale.origin = bytes.text();
  map.features = get_orb_options(bytes);
  bytes.finish();
}

std::string body_of(const LandmarkKeyframe& keyframe) {
  ByteWriter bytes;
  bytes.put(keyframe.frame);
  bytes.put(keyframe.stamp);
  put(bytes, keyframe.features);
  put(bytes, keyframe.right_x);
  put(bytes, keyframe.depths);
  return bytes.take();
}

std::shared_ptr<const LandmarkKeyframe> read_landmark_keyframe(std::string_view body, std::int64_t id,
                                                               const std::string& where) {
  ByteReader bytes(body, where);
  auto keyframe = std::make_shared<LandmarkKeyframe>();
  keyframe->id = id;
  keyframe->frame = bytes.get<std::int64_t>();
  keyframe->stamp = bytes.get<TimeNs>();
  keyframe->features = get_features(bytes);
  keyframe->right_x = get_floats(bytes, keyframe->features.size());
  keyframe->depths = get_floats(bytes, keyframe->features.size());
  bytes.finish();
  return keyframe;
}

std::string body_of(const LandmarkKeyframePose& pose) {
  ByteWriter bytes;
  bytes.put<std::int32_t>(pose.submap);
  bytes.put(pose.parent);
  put(bytes, pose.world_from_camera);
  return bytes.take();
}

LandmarkKeyframePose read_landmark_keyframe_pose(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  LandmarkKeyframePose pose;
  pose.submap = bytes.get<std::int32_t>();
  pose.parent = bytes.get<std::int64_t>();
  bytes.check(pose.submap >= 0 && pose.parent >= -1);
  pose.world_from_camera = get_pose(bytes);
  bytes.finish();
  return pose;
}

std::string body_of(const Landmark& landmark) {
  ByteWriter bytes;
  put(bytes, landmark.position);
  put(bytes, landmark.direction);
  bytes.put_raw(landmark.descriptor.words.data(), sizeof landmark.descriptor.words);
  bytes.put(landmark.min_distance);
  bytes.put(landmark.max_distance);
  bytes.put(static_cast<std::uint32_t>(landmark.observations.size()));
  for (const LandmarkObservation& observation : landmark.observations) {
    bytes.put(observation.keyframe);
    bytes.put(observation.feature);
  }
  return bytes.take();
}

Landmark read_landmark(std::string_view body, std::int64_t id, const std::string& where) {
  ByteReader bytes(body, where);
  Landmark landmark;
  landmark.id = id;
  landmark.position = get_vector(bytes);
  landmark.direction = get_vector(bytes);
  for (std::uint64_t& word : landmark.descriptor.words) word = bytes.get<std::uint64_t>();
  landmark.min_distance = bytes.get<float>();
  landmark.max_distance = bytes.get<float>();
  landmark.observations.resize(bytes.count(sizeof(std::int64_t) + sizeof(std::uint32_t)));
  std::int64_t last = -1;
  for (LandmarkObservation& observation : landmark.observations) {
    observation.keyframe = bytes.get<std::int64_t>();
    observation.feature = bytes.get<std::uint32_t>();
    bytes.check(observation.keyframe > last);
    last = observation.keyframe;
  }
  bytes.finish();
  return landmark;
}

std::string body_of(const LandmarkTie& tie) {
  ByteWriter bytes;
  bytes.put(tie.from);
  bytes.put(tie.to);
  bytes.put<std::int32_t>(tie.inliers);
  bytes.put(tie.from_from_to.scale());
  put(bytes, tie.from_from_to.rotation());
  put(bytes, tie.from_from_to.translation());
  return bytes.take();
}

LandmarkTie read_tie(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  LandmarkTie tie;
  tie.from = bytes.get<std::int64_t>();
  tie.to = bytes.get<std::int64_t>();
  tie.inliers = bytes.get<std::int32_t>();
  const auto scale = bytes.get<double>();
  bytes.check(scale > 0.0);
  const SO3 rotation = get_rotation(bytes);
  tie.from_from_to = Sim3(scale, rotation, get_vector(bytes));
  bytes.finish();
  return tie;
}

}  // namespace rastro
