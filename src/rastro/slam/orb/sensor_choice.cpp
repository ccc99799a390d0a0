// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/sensor_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/camera/rolling_shutter.h"
#include "rastro/odometry/rgbd_tracking/depth_reading.h"
#include "rastro/slam/orb/tracking/stereo_matching.h"

namespace rastro {
namespace {

constexpr int pixels_of_vga = 640 * 480;

RgbdOptions farther_reading() {
  RgbdOptions options;
  options.max_depth_m = 20.0;
  return options;
}

/// No depth at object boundaries, where it may belong to either side.
float depth_at(const DepthImage& depth, const Camera& camera, const Keypoint& keypoint, const SE3& depth_from_color) {
  if (depth.empty()) return 0.0F;
  const auto ray = camera.unproject(Eigen::Vector2d(keypoint.x, keypoint.y));
  if (!ray) return 0.0F;
  static const RgbdOptions reading = farther_reading();
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

/// Whether corresponding points are in the same row of both images: pinhole cameras of one kind, side by side.
bool is_rectified(const SourceInfo& source) {
  if (source.cameras.size() < 2 || !source.cameras[1].camera || !source.left_from_right) return false;
  const Camera &left = *source.cameras[0].camera, &right = *source.cameras[1].camera;
  constexpr double most_px = 0.5, most_rad = 0.001, most_share = 0.005;
  const Eigen::Vector3d aside = source.left_from_right->translation();
  return left.distortion == Distortion::none && right.distortion == Distortion::none &&
         std::abs(left.fx - right.fx) < most_px && std::abs(left.fy - right.fy) < most_px &&
         std::abs(left.cx - right.cx) < most_px && std::abs(left.cy - right.cy) < most_px &&
         source.left_from_right->rotation().log().norm() < most_rad && aside.x() > 0.0 &&
         std::hypot(aside.y(), aside.z()) < most_share * aside.x();
}

/// Chooses both cameras, rectified where they are not; with `auto` only the left one if they cannot be rectified.
void choose_pair(const OrbSlamOptions& options, const SourceInfo& source, SensorChoice& choice) {
  choice.sensor = CameraKind::stereo;
  if (is_rectified(source)) {
    choice.baseline = source.left_from_right->translation().x();
    return;
  }
  const bool calibrated = source.cameras.size() > 1 && source.cameras[1].camera && source.left_from_right;
  auto made =
      calibrated ? rectify_stereo(choice.camera, *source.cameras[1].camera, *source.left_from_right) : std::nullopt;
  if (made) {
    choice.rectification = std::make_shared<StereoRectification>(std::move(*made));
    choice.camera = choice.rectification->camera;
    choice.baseline = choice.rectification->baseline;
    return;
  }
  const char* why =
      calibrated ? "has stereo images of cameras that are not side by side, or whose sizes are not in the calibration"
                 : "has stereo images without calibration of both cameras and their baseline";
  if (options.sensor == "stereo") throw Error(why, source.path, "give --calibration FILE, or --sensor mono");
  log_warning(fmt::format("{} {}: only the left camera is used", source.path, why));
  choice.sensor = CameraKind::mono;
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

FrameRectifier::FrameRectifier(std::shared_ptr<const StereoRectification> rectification, TaskPool* pool)
    : rectification_(std::move(rectification)), pool_(pool) {
  constexpr int margin = 16;  // Corners at the border of the valid area are artifacts; the coarsest level reaches this
                              // far.
  const Camera& camera = rectification_->camera;  // of the recorded size
  shown_ = shown_by(rectification_->left, camera.width, camera.height, margin);
}

Frame FrameRectifier::rectified(const Frame& frame) const {
  const auto is_of_camera = [&](GrayView image) {
    return image.width == rectification_->camera.width && image.height == rectification_->camera.height;
  };
  if (!is_of_camera(frame.image.view()) || !(frame.right.empty() || is_of_camera(frame.right.view())))
    throw Error("has another size than the calibration", fmt::format("frame {}", frame.index),
                "give the calibration of these images");
  Frame made;
  made.index = frame.index;
  made.stamp = frame.stamp;
  made.name = frame.name;
  made.image = remap(frame.image.view(), rectification_->left, pool_);
  if (!frame.right.empty()) made.right = remap(frame.right.view(), rectification_->right, pool_);
  made.mask = shown_;
  if (frame.mask.empty()) return made;
  const GrayImage mask = remap(frame.mask.view(), rectification_->left, pool_);
  constexpr std::uint8_t half = 128;  // The border of a mask has interpolated values.
  for (int y = 0; y < mask.height(); ++y)
    std::transform(mask.row(y), mask.row(y) + mask.width(), made.mask.row(y), made.mask.row(y),
                   [](std::uint8_t a, std::uint8_t b) { return a < half ? std::uint8_t{0} : b; });
  return made;
}

void check_map(const Map& map, const SensorChoice& choice, bool extend) {
  if (map.method != "orb")
    throw Error("was made by method '" + map.method + "'", "--map", "give a map made by --method orb");
  if (!map.layer<FeatureLayer>() || !map.layer<LandmarkLayer>() || map.cameras.empty())
    throw Error("has no features, no landmarks or no camera", "--map", "give a map made by --method orb");
  const auto features = map.layer<FeatureLayer>();
  for (const Keyframe& keyframe : map.keyframes)
    if (!features->find(keyframe.id))
      throw Error("has keyframes without features", "--map",
                  "give a complete map; 'rastro info' says what this one lacks");
  if (map.cameras.front().kind != choice.sensor && (extend || choice.sensor != CameraKind::mono))
    throw Error("was made with another sensor", "--map",
                "give the --sensor of the map, or --sensor mono, which works with any map");
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
    const auto read = [&](int begin, int end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
        data->depths[i] = depth_at(frame.depth, sensor_.camera, data->features.keypoints[i], depth_from_color);
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
