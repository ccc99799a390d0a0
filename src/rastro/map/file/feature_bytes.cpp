// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/feature_bytes.h"

namespace rastro {

static_assert(sizeof(Keypoint) == 5 * sizeof(float) && sizeof(Descriptor) == 32);

void put(ByteWriter& bytes, const std::vector<float>& values) {
  bytes.put(static_cast<std::uint32_t>(values.size()));
  bytes.put_raw(values.data(), values.size() * sizeof(float));
}

std::vector<float> get_floats(ByteReader& bytes) {
  std::vector<float> values(bytes.count(sizeof(float)));
  for (float& value : values) value = bytes.get<float>();
  return values;
}

std::vector<Keypoint> get_keypoints(ByteReader& bytes, std::size_t count) {
  bytes.check(count <= bytes.left() / sizeof(Keypoint));
  std::vector<Keypoint> keypoints(count);
  for (Keypoint& point : keypoints)
    for (float* value : {&point.x, &point.y, &point.size_px, &point.angle_rad, &point.response})
      *value = bytes.get<float>();
  return keypoints;
}

std::vector<Descriptor> get_descriptors(ByteReader& bytes, std::size_t count) {
  bytes.check(count <= bytes.left() / sizeof(Descriptor));
  std::vector<Descriptor> descriptors(count);
  const std::string_view raw = bytes.raw(count * sizeof(Descriptor));
  if (count > 0) std::memcpy(descriptors.data(), raw.data(), raw.size());
  return descriptors;
}

void put(ByteWriter& bytes, const Features& features) {
  bytes.put(static_cast<std::uint32_t>(features.size()));
  bytes.put_raw(features.keypoints.data(), features.size() * sizeof(Keypoint));
  bytes.put(static_cast<std::uint8_t>(!features.levels.empty()));
  bytes.put_raw(features.levels.data(), features.levels.size());
  bytes.put<std::int32_t>(features.length);
  put(bytes, features.floats);
  bytes.put_raw(features.descriptors.data(), features.descriptors.size() * sizeof(Descriptor));
}

Features get_features(ByteReader& bytes) {
  constexpr std::int32_t longest = 4096;
  Features features;
  const std::size_t count = bytes.count(sizeof(Keypoint));
  features.keypoints = get_keypoints(bytes, count);
  const auto with_levels = bytes.get<std::uint8_t>();
  bytes.check(with_levels <= 1);
  if (with_levels == 1) {
    const std::string_view levels = bytes.raw(count);
    features.levels.assign(levels.begin(), levels.end());
  }
  features.length = bytes.get<std::int32_t>();
  bytes.check(features.length >= 0 && features.length <= longest);
  features.floats = get_floats(bytes);
  bytes.check(features.floats.size() == count * static_cast<std::size_t>(features.length));
  if (features.binary()) features.descriptors = get_descriptors(bytes, count);
  return features;
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

void put(ByteWriter& bytes, const ImageFeatures& image) {
  bytes.put(image.frame);
  bytes.put(image.stamp);
  put(bytes, image.features);
  put(bytes, image.right_x);
  put(bytes, image.depths);
}

std::shared_ptr<ImageFeatures> get_image_features(ByteReader& bytes) {
  auto image = std::make_shared<ImageFeatures>();
  image->frame = bytes.get<std::int64_t>();
  image->stamp = bytes.get<TimeNs>();
  image->features = get_features(bytes);
  image->right_x = get_floats(bytes);
  image->depths = get_floats(bytes);
  return image;
}

}  // namespace rastro
