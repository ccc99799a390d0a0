// SPDX-License-Identifier: Apache-2.0
#include "accuracy_input.h"

#include <algorithm>
#include <functional>
#include <map>

#include "rastro/base/random.h"
#include "rastro/dataset/open.h"
#include "rastro/synthetic/kinect_model.h"
#include "rastro/synthetic/laser_model.h"
#include "rastro/synthetic/odometry_model.h"
#include "rastro/synthetic/worlds/corridor.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/worlds/loop.h"
#include "rastro/synthetic/worlds/rooms.h"
#include "rastro/synthetic/worlds/street.h"
#include "rastro/synthetic/write_laser_log.h"

namespace rastro {
namespace {

constexpr double image_scale = 0.5;  ///< Of what `rastro simulate` writes: rendering is most of the time.
constexpr std::uint64_t depth_seed = 21;

World make_world(const std::string& name) {
  constexpr int threads = 2;
  const std::map<std::string, std::function<World()>> worlds = {
      {"hall", [] { return make_hall({.scale = image_scale, .threads = threads}); }},
      {"street", [] { return make_street({.scale = image_scale, .threads = threads}); }},
      {"loop", [] { return make_loop({.scale = image_scale, .threads = threads}); }},
      {"corridor", [] { return make_corridor({.scale = image_scale, .threads = threads}); }},
      {"bedroom", [] { return make_bedroom({.scale = image_scale, .threads = threads}); }},
      {"study", [] { return make_study({.scale = image_scale, .threads = threads}); }}};
  return worlds.at(name)();
}

/// Frames [first, end) of a world, with the measurements of the sensor.
class ChosenFrames : public Source {
 public:
  ChosenFrames(const World& world, const AccuracyRow& row) : world_(world), sensor_(row.sensor), row_(row), pool_(2) {
    info_.path = row.recording;
    info_.format = "synthetic";
    info_.cameras.push_back({"cam0", world.camera(), std::nullopt, "generated"});
    info_.has_depth = sensor_ == "rgbd";
    info_.has_right = sensor_ == "stereo";
    if (info_.has_right) {
      info_.cameras.push_back({"cam1", world.camera(), std::nullopt, "generated"});
      info_.left_from_right = world.left_from_right();
    }
    info_.frame_count = row.end - row.first;
    next_ = row.first;
  }
  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (next_ >= row_.end) return std::nullopt;
    RenderedFrame rendered = world_.render(next_, pool_);
    Frame frame;
    frame.index = next_ - row_.first;
    frame.stamp = frame.depth_stamp = world_.stamp(next_);
    frame.name = row_.recording + " frame " + std::to_string(next_);
    frame.image = std::move(rendered.gray);
    frame.color = std::move(rendered.color);
    if (info_.has_right) frame.right = world_.render_right(next_, pool_).gray;
    if (info_.has_depth) add_depth(frame);
    ++next_;
    return frame;
  }

 private:
  /// As measured by the world's depth camera, a little later than the color image.
  void add_depth(Frame& frame) {
    const KinectModel& kinect = world_.kinect().value();
    const double time = world_.time_of(next_) + kinect.delay_s;
    const std::uint64_t noise = seed_for(seed_for(world_.seed(), depth_seed), static_cast<std::uint64_t>(next_));
    const Image<std::uint16_t> raw = kinect_depth(world_.depth_at(time, pool_), world_.renderer(),
                                                  world_.world_from_camera_at(time), kinect, noise, pool_);
    frame.depth = DepthImage(raw.width(), raw.height());
    for (int y = 0; y < raw.height(); ++y) {
      for (int x = 0; x < raw.width(); ++x)
        frame.depth.at(x, y) = static_cast<float>(raw.at(x, y) / kinect.units_per_meter);
    }
    frame.depth_stamp = frame.stamp + from_seconds(kinect.delay_s);
  }

  const World& world_;
  std::string sensor_;
  AccuracyRow row_;
  TaskPool pool_;
  SourceInfo info_;
  std::int64_t next_ = 0;
};

AccuracyInput open_world(const AccuracyRow& row) {
  AccuracyInput input;
  const auto world = std::make_shared<const World>(make_world(row.recording.substr(6)));
  for (std::int64_t k = row.first; k < row.end; ++k)
    input.ground_truth.push_back({world->stamp(k), world->world_from_camera(k)});
  input.source = std::make_unique<ChosenFrames>(*world, row);
  input.world = world;
  return input;
}

SE3 raised(const SE2& pose) {
  return {SO3::exp(pose.rotation().angle() * Eigen::Vector3d::UnitZ()),
          {pose.translation().x(), pose.translation().y(), 0.0}};
}

/// The robot's log of the office floor, written into a scratch folder and read back, as a user would.
AccuracyInput open_laser_world(const AccuracyRow& row) {
  AccuracyInput input;
  const auto world = std::make_shared<const LaserWorld>(make_corridor_floor({.threads = 2}));
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("rastro_accuracy_" + row.name());
  TaskPool pool(2);
  write_laser_log(*world, folder, {.scans = row.end, .force = true}, pool);
  OpenOptions options;
  options.first_frame = row.first;
  input.source = open((folder / "scans.log").string(), options);
  for (std::int64_t k = row.first; k < row.end; ++k)
    input.ground_truth.push_back({world->stamp(k), raised(world->world_from_body(world->time_of(k)))});
  input.world = world;
  return input;
}

AccuracyInput open_recorded(const AccuracyRow& row) {
  AccuracyInput input;
  OpenOptions options;
  options.first_frame = row.first;
  options.end_frame = row.end;
  options.want_right = row.sensor == "stereo";
  options.want_depth = options.want_color = row.sensor == "rgbd";
  // 7-Scenes come without a calibration; this is the one that is published with them.
  if (row.recording == "kitchen_rgbd") options.intrinsics = {585.0, 585.0, 320.0, 240.0};
  const std::filesystem::path file = recorded_file(row);
  input.source = open(file.string(), options);
  if (row.alignment == "relations") {
    std::string relations = file.string();
    relations.replace(relations.find(".clf.gz"), std::string::npos, ".relations");
    input.relations = parse_relations(read_text_file(relations), relations);
    return input;
  }
  const SourceInfo& info = input.source->info();
  input.ground_truth = info.ground_truth;
  if (info.ground_truth_frame == "body" && !info.cameras.empty() && info.cameras.front().body_from_camera) {
    for (StampedPose& pose : input.ground_truth)
      pose.world_from_body = pose.world_from_body * *info.cameras.front().body_from_camera;
  }
  return input;
}

}  // namespace

std::filesystem::path recorded_data() {
  const char* set = std::getenv("RASTRO_DATA");
  const char* source_dir = std::getenv("RASTRO_SOURCE_DIR");
  return set && *set ? std::filesystem::path(set)
                     : std::filesystem::path(source_dir ? source_dir : ".") / "../shared/data";
}

std::filesystem::path recorded_file(const AccuracyRow& row) {
  return row.is_generated() ? std::filesystem::path() : recorded_data() / row.recording;
}

AccuracyInput open_input(const AccuracyRow& row) {
  if (!row.is_generated()) return open_recorded(row);
  return row.sensor == "laser" ? open_laser_world(row) : open_world(row);
}

}  // namespace rastro
