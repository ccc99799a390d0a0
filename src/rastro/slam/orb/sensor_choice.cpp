// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/sensor_choice.h"

#include <cmath>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr int pixels_of_vga = 640 * 480;

/// Of the pixels around the feature that have one: depth pictures have holes.
float depth_at(const DepthImage& depth, const Keypoint& keypoint) {
  const int x = static_cast<int>(std::lround(keypoint.x)), y = static_cast<int>(std::lround(keypoint.y));
  if (x < 0 || y < 0 || x >= depth.width() || y >= depth.height()) return 0.0F;
  return depth.at(x, y);
}

}  // namespace

OrbSlamOptions options_for(OrbSlamOptions options, const SourceInfo& source, const LandmarkMap* map) {
  OrbSlamOptions copy = options;
  OptionTable table = option_table(copy);
  for (std::size_t i = 0; i < table.options().size(); ++i)
    table.set(table.options()[i].name, table.value_of(i), "orb options");
  if (map != nullptr) {
    options.features = map->features.features;
    options.levels = map->features.levels;
    options.scale_factor = map->features.scale_factor;
    options.fast_threshold = map->features.fast_threshold;
    options.least_fast_threshold = map->features.least_fast_threshold;
  }
  if (options.features == 0) {
    const Camera& camera = *source.cameras.front().camera;
    options.features = camera.width > 0 && camera.width * camera.height > 1.3 * pixels_of_vga ? 2000 : 1000;
  }
  return options;
}

OrbOptions orb_options(const OrbSlamOptions& options) {
  return {options.features, options.levels, options.scale_factor, options.fast_threshold, options.least_fast_threshold};
}

SensorChoice choose_sensor(const OrbSlamOptions& options, const SourceInfo& source) {
  SensorChoice choice;
  choice.camera = *source.cameras.front().camera;
  const bool rgbd = options.sensor == "rgbd" || (options.sensor == "auto" && source.has_depth);
  if (rgbd) {
    if (!source.has_depth) throw Error("holds no depth images", source.path, "'sensor=mono' works with images alone");
    choice.sensor = LandmarkSensor::rgbd;
    choice.baseline = options.virtual_baseline_m;
  }
  return choice;
}

void check_map(const LandmarkMap& map, const SensorChoice& choice, bool extend) {
  if (map.method != "orb")
    throw Error("was made by method '" + map.method + "'", "--map", "give a map that 'orb' made");
  if (map.sensor != choice.sensor && (extend || choice.sensor != LandmarkSensor::mono))
    throw Error("was made with other sensors than this run has", "--map",
                "give --sensor as when it was made; --sensor mono finds its way in any map");
}

FeatureMaker::FeatureMaker(const OrbSlamOptions& options, const SensorChoice& sensor, TaskPool* pool)
    : options_(options), sensor_(sensor), pool_(pool), extractor_(orb_options(options)) {}

std::shared_ptr<const FeatureFrame> FeatureMaker::make(const Frame& frame) {
  auto data = std::make_shared<LandmarkKeyframe>();
  data->id = -1;
  data->frame = frame.index;
  data->stamp = frame.stamp;
  data->features = extractor_.extract(frame.image.view(), frame.mask.view(), pool_);
  if (sensor_.sensor == LandmarkSensor::rgbd) {
    for (const Keypoint& keypoint : data->features.keypoints)
      data->depths.push_back(frame.depth.empty() ? 0.0F : depth_at(frame.depth, keypoint));
  }
  return std::make_shared<FeatureFrame>(std::move(data), sensor_.camera, sensor_.baseline);
}

}  // namespace rastro
