// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/sensor_choice.h"

#include <algorithm>
#include <cmath>

#include "rastro/backend/map_camera.h"
#include "rastro/base/error.h"
#include "rastro/camera/rolling_shutter.h"
#include "rastro/odometry/rgbd_tracking/depth_reading.h"
#include "rastro/slam/orb/tracking/stereo_matching.h"

namespace rastro {
namespace {

constexpr int pixels_of_vga = 640 * 480;

RgbdOptions depth_reading(const OrbSlamOptions& options) {
  RgbdOptions reading;
  reading.max_depth_m = 20.0;
  reading.depth_edge_sigmas = options.depth_edge_sigmas;
  return reading;
}

/// No depth at object boundaries, where it may belong to either side.
float depth_at(const DepthImage& depth, const Camera& camera, const Keypoint& keypoint, const SE3& depth_from_color,
               const RgbdOptions& reading) {
  if (depth.empty()) return 0.0F;
  const auto ray = camera.unproject(Eigen::Vector2d(keypoint.x, keypoint.y));
  if (!ray) return 0.0F;
  const auto read = read_depth(depth, camera, *ray, depth_from_color, reading);
  return read ? static_cast<float>(1.0 / read->inverse_depth) : 0.0F;
}

}  // namespace

OrbSlamOptions options_for(OrbSlamOptions options, const SourceInfo& source, const Map* map) {
  OrbSlamOptions copy = options;
  OptionTable table = option_table(copy);
  for (std::size_t i = 0; i < table.options().size(); ++i)
    table.set(table.options()[i].name, table.value_of(i), "orb options");
  if (map != nullptr) {
    const bool is_of_one_camera = !map->cameras.empty() && map->cameras.front().kind == CameraKind::mono;
    if (options.sensor == "auto" && is_of_one_camera) options.sensor = "mono";
    const auto layer = map->layer<FeatureLayer>();
    const OrbOptions extraction = layer ? layer->extraction : OrbOptions{};
    options.features = extraction.features;
    options.levels = extraction.levels;
    options.scale_factor = extraction.scale_factor;
    options.fast_threshold = extraction.fast_threshold;
    options.least_fast_threshold = extraction.least_fast_threshold;
  }
  if (options.features == 0) {
    const Camera& camera = *source.cameras.front().camera;
    options.features = camera.width * camera.height > 1.3 * pixels_of_vga ? 2000 : 1000;
  }
  return options;
}

OrbOptions orb_options(const OrbSlamOptions& options) {
  return {options.features, options.levels, options.scale_factor, options.fast_threshold, options.least_fast_threshold};
}

namespace {

/// Chooses both cameras, rectified where they are not; with `auto` only the left one if they cannot be rectified.
void choose_pair(const OrbSlamOptions& options, const SourceInfo& source, SensorChoice& choice) {
  const auto pair = choose_stereo_pair(source, options.sensor == "stereo");
  if (!pair) return;
  choice.sensor = CameraKind::stereo;
  choice.rectification = pair->rectification;
  choice.camera = pair->camera;
  choice.baseline = pair->baseline;
}

}  // namespace

SE3 SensorChoice::camera_from_left() const {
  return rectification ? SE3(rectification->left_from_rectified.inverse(), Eigen::Vector3d::Zero()) : SE3();
}

SensorChoice choose_sensor(const OrbSlamOptions& options, const SourceInfo& source) {
  SensorChoice choice;
  choice.camera = *source.cameras.front().camera;
  if (options.sensor == "rgbd" && !source.has_depth)
    throw Error("has no depth images", source.path, "use --sensor mono");
  if (options.sensor == "stereo" && !source.has_right)
    throw Error("has no right images", source.path, "use --sensor mono");
  if (options.sensor == "rgbd" || (options.sensor == "auto" && source.has_depth)) {
    choice.sensor = CameraKind::depth;
    choice.baseline = options.virtual_baseline_m;
  } else if (options.sensor == "stereo" || (options.sensor == "auto" && source.has_right)) {
    choose_pair(options, source, choice);
  }
  return choice;
}

void check_map(const Map& map, const SensorChoice& choice, bool extend, const std::string& method) {
  if (map.method != method)
    throw Error("was made by method '" + map.method + "'", "--map", "give a map made by --method " + method);
  if (!map.layer<FeatureLayer>() || !map.layer<LandmarkLayer>() || map.cameras.empty())
    throw Error("has no features, no landmarks or no camera", "--map", "give a map made by --method " + method);
  const auto features = map.layer<FeatureLayer>();
  for (const Keyframe& keyframe : map.keyframes)
    if (!features->find(keyframe.id))
      throw Error("has keyframes without features", "--map",
                  "give a complete map; 'rastro info' says what this one lacks");
  if (map.cameras.front().kind != choice.sensor && (extend || choice.sensor != CameraKind::mono))
    throw Error("was made with another sensor", "--map",
                "give the --sensor of the map, or --sensor mono, which works with any map");
  // Keyframes go on with the camera of this run; where the map stays as it is, only the positions of landmarks count.
  if (extend) require_camera_of_map(map.cameras.front().intrinsics, choice.camera);
}

FeatureMaker::FeatureMaker(const OrbSlamOptions& options, const SensorChoice& sensor, TaskPool* pool)
    : options_(options), sensor_(sensor), pool_(pool), extractor_(orb_options(options)) {
  if (sensor.camera.readout_s > 0.0) shutter_.emplace(sensor.camera, options.seed, pool);
}

std::shared_ptr<const FeatureFrame> FeatureMaker::make(const Frame& frame, const SE3& depth_from_color) {
  auto data = std::make_shared<ImageFeatures>();
  data->frame = frame.index;
  data->stamp = frame.stamp;
  data->features = extractor_.extract(frame.image.view(), frame.mask.view(), pool_);
  if (sensor_.sensor == CameraKind::depth) {
    data->depths.resize(data->features.size());
    const RgbdOptions reading = depth_reading(options_);
    const auto read = [&](int begin, int end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
        data->depths[i] = depth_at(frame.depth, sensor_.camera, data->features.keypoints[i], depth_from_color, reading);
    };
    const auto count = static_cast<int>(data->features.size());
    pool_ != nullptr ? pool_->for_chunks(0, count, 64, read) : read(0, count);
  }
  if (sensor_.sensor == CameraKind::stereo) {
    data->right_x.assign(data->features.size(), -1.0F);
    data->depths.assign(data->features.size(), 0.0F);
    if (!frame.right.empty())
      match_stereo(frame.image.view(), frame.right.view(), extractor_.extract(frame.right.view(), {}, pool_),
                   sensor_.camera.fx * sensor_.baseline, options_, pool_, *data);
  }
  if (shutter_) angular_velocity_ = shutter_->next(data);
  if (angular_velocity_) return at_middle_row(*data);
  return std::make_shared<FeatureFrame>(std::move(data), sensor_.camera, sensor_.baseline);
}

std::shared_ptr<const FeatureFrame> FeatureMaker::with_rotation(const FeatureFrame& frame) const {
  return at_middle_row(frame.data());
}

std::shared_ptr<const FeatureFrame> FeatureMaker::at_middle_row(ImageFeatures features) const {
  for (std::size_t i = 0; i < features.features.size(); ++i) {
    Keypoint& keypoint = features.features.keypoints[i];
    const auto moved = rastro::at_middle_row(sensor_.camera, {keypoint.x, keypoint.y}, *angular_velocity_);
    keypoint.x = static_cast<float>(moved.pixel.x());
    keypoint.y = static_cast<float>(moved.pixel.y());
    if (!features.depths.empty()) features.depths[i] *= static_cast<float>(moved.depth_factor);
  }
  return std::make_shared<FeatureFrame>(std::make_shared<ImageFeatures>(std::move(features)), sensor_.camera,
                                        sensor_.baseline);
}

}  // namespace rastro
