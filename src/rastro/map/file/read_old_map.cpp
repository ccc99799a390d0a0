// SPDX-License-Identifier: Apache-2.0
// Maps as versions 1 and 2 of the format have them, in the form of today.
#include <optional>

#include "rastro/base/error.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/feature_bytes.h"
#include "rastro/map/file/landmark_bytes.h"
#include "rastro/map/file/read_map.h"
#include "rastro/map/file/row_parts.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

/// The head of a map of version 2 begins with this; no method has this name.
constexpr std::string_view landmark_mark = "map of landmarks";

struct OldPose {
  int submap = 0;
  KeyframeId parent = no_keyframe;
  SE3 world_from_camera;
};

/// The common part of both versions: features and poses of keyframes in two tables, and a trajectory.
class OldMap {
 public:
  explicit OldMap(RowSource& rows) : rows_(rows) {}

  void need_head(const RowSource::Read& read) {
    if (!with_head(rows_, read))
      throw Error("nothing of a map was found", rows_.file(), "give the map.rastro of a run");
  }

  void read_keyframes(const std::function<std::shared_ptr<ImageFeatures>(ByteReader&)>& read_image,
                      const std::function<OldPose(ByteReader&)>& read_pose) {
    auto features = std::make_shared<FeatureLayer>();
    features->extraction = extraction;
    rows_.each("keyframes", [&](std::string_view body, std::int64_t id, const std::string& where) {
      ByteReader bytes(body, where);
      auto image = read_image(bytes);
      bytes.finish();
      bytes.check(id >= 0);
      image->id = id;
      features->of[id] = std::move(image);
    });
    rows_.each("poses", [&](std::string_view body, std::int64_t id, const std::string& where) {
      ByteReader bytes(body, where);
      const OldPose pose = read_pose(bytes);
      bytes.finish();
      bytes.check(pose.submap >= 0 && pose.parent >= no_keyframe);
      const ImageFeatures* image = features->find(id);
      if (!image) refuse_damaged(where, "is of a keyframe that is not there");
      map->keyframes.push_back(
          {id, image->frame, image->stamp, 0, pose.world_from_camera, pose.submap, pose.parent, 1.0});
    });
    if (rows_.stored("poses") && map->keyframes.size() != features->of.size())
      refuse_damaged(rows_.file(), "does not have a pose for every keyframe");
    map->layers.put<FeatureLayer>(std::move(features));
  }

  void read_trajectory() {
    rows_.each("way", [&](std::string_view body, std::int64_t, const std::string& where) {
      ByteReader bytes(body, where);
      StampedPose pose;
      pose.stamp = bytes.get<TimeNs>();
      pose.world_from_body = get_pose(bytes);
      bytes.finish();
      if (const auto frame = frame_in(*map, pose)) map->frames.push_back(*frame);
    });
  }

  OrbOptions extraction;
  std::shared_ptr<Map> map = std::make_shared<Map>();

 private:
  RowSource& rows_;
};

std::shared_ptr<ImageFeatures> depth_camera_image(ByteReader& bytes) {
  auto image = std::make_shared<ImageFeatures>();
  image->frame = bytes.get<std::int64_t>();
  image->stamp = bytes.get<TimeNs>();
  Features& features = image->features;
  features.keypoints = get_keypoints(bytes, bytes.count(sizeof(Keypoint)));
  features.length = bytes.get<std::int32_t>();
  bytes.check(features.length >= 0);
  features.floats = get_floats(bytes);
  bytes.check(features.floats.size() == features.size() * static_cast<std::size_t>(features.length));
  features.descriptors = get_descriptors(bytes, bytes.count(sizeof(Descriptor)));
  bytes.check(features.descriptors.size() == (features.binary() ? features.size() : 0));
  image->depths = get_floats(bytes);
  bytes.check(image->depths.size() == features.size());
  return image;
}

std::shared_ptr<ImageFeatures> landmark_image(ByteReader& bytes) {
  auto image = std::make_shared<ImageFeatures>();
  image->frame = bytes.get<std::int64_t>();
  image->stamp = bytes.get<TimeNs>();
  const std::size_t count = bytes.count(sizeof(Keypoint) + 1 + sizeof(Descriptor));
  image->features.keypoints = get_keypoints(bytes, count);
  const std::string_view levels = bytes.raw(count);
  image->features.levels.assign(levels.begin(), levels.end());
  image->features.descriptors = get_descriptors(bytes, count);
  image->right_x = get_floats(bytes);
  image->depths = get_floats(bytes);
  return image;
}

Constraint depth_camera_edge(ByteReader& bytes) {
  constexpr ConstraintKind kinds[] = {ConstraintKind::odometry, ConstraintKind::proximity, ConstraintKind::loop,
                                      ConstraintKind::merge};
  Constraint edge;
  edge.from = bytes.get<KeyframeId>();
  edge.to = bytes.get<KeyframeId>();
  const auto kind = bytes.get<std::uint8_t>();
  bytes.check(kind < std::size(kinds));
  edge.kind = kinds[kind];
  edge.weight = bytes.get<double>();
  edge.from_from_to = Sim3(get_pose(bytes));
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) edge.information(row, column) = bytes.get<double>();
  return edge;
}

Constraint landmark_constraint(ByteReader& bytes) {
  Constraint constraint;
  constraint.from = bytes.get<KeyframeId>();
  constraint.to = bytes.get<KeyframeId>();
  constraint.kind = ConstraintKind::loop;
  constraint.inliers = bytes.get<std::int32_t>();
  const auto scale = bytes.get<double>();
  bytes.check(scale > 0.0);
  const SO3 rotation = get_rotation(bytes);
  constraint.from_from_to = Sim3(scale, rotation, get_vector(bytes));
  return constraint;
}

void read_constraints(RowSource& rows, const char* table, Constraint (*read)(ByteReader&), Map& map) {
  rows.each(table, [&](std::string_view body, std::int64_t, const std::string& where) {
    ByteReader bytes(body, where);
    map.constraints.push_back(read(bytes));
    bytes.finish();
  });
}

void read_landmark_head(std::string_view body, const std::string& where, OldMap& old) {
  constexpr CameraKind kinds[] = {CameraKind::mono, CameraKind::stereo, CameraKind::depth};
  ByteReader bytes(body, where);
  MapCamera camera;
  MapScale scale;
  bytes.check(bytes.text() == landmark_mark);
  old.map->method = bytes.text();
  const auto sensor = bytes.get<std::uint8_t>();
  bytes.check(sensor < std::size(kinds));
  camera.kind = kinds[sensor];
  camera.intrinsics = get_camera(bytes);
  camera.baseline = bytes.get<double>();
  bytes.check(camera.baseline >= 0.0);
  const auto metric = bytes.get<std::uint8_t>();
  bytes.check(metric <= 1);
  scale.metric = metric == 1;
  scale.relative_sigma = bytes.get<double>();
  bytes.check(scale.relative_sigma >= 0.0);
  scale.origin = bytes.text();
  old.extraction = get_orb_options(bytes);
  bytes.finish();
  old.map->cameras = {camera};
  old.map->sessions = {{0, 0, "", 0, 0, scale}};
}

}  // namespace

bool is_landmark_head(std::string_view body) {
  ByteWriter mark;
  mark.put_text(landmark_mark);
  return body.starts_with(mark.take());
}

std::shared_ptr<Map> read_depth_camera_map(RowSource& rows) {
  OldMap old(rows);
  old.need_head([&](std::string_view body, std::int64_t, const std::string& where) {
    ByteReader bytes(body, where);
    MapCamera camera;
    camera.kind = CameraKind::depth;
    old.map->method = bytes.text();
    camera.intrinsics = get_camera(bytes);
    camera.depth_noise.sigma_m = bytes.get<double>();
    camera.depth_noise.sigma_per_m2 = bytes.get<double>();
    bytes.finish();
    old.map->cameras = {camera};
    old.map->sessions = {{0, 0, "", 0, 0, {true, 0.0, "depth camera"}}};
  });
  old.read_keyframes(depth_camera_image, [](ByteReader& bytes) {
    OldPose pose;
    pose.submap = bytes.get<std::int32_t>();
    pose.world_from_camera = get_pose(bytes);
    return pose;
  });
  read_constraints(rows, "edges", depth_camera_edge, *old.map);
  old.read_trajectory();
  const LayerType& type = *layer_type(ImageLayer::layer_name);
  const std::shared_ptr<Layer> images = type.make({}, rows.file());
  if (const auto stored = rows.stored("pictures")) {
    rows.each_id("pictures", [&](std::int64_t id) { type.read(*images, id, {}, rows.file()); });
    type.attach(*images, stored);
  } else {
    rows.each("pictures", [&](std::string_view body, std::int64_t id, const std::string& where) {
      type.read(*images, id, body, where);
    });
  }
  old.map->layers.put(ImageLayer::layer_name, images);
  return old.map;
}

std::shared_ptr<Map> read_landmark_map(RowSource& rows) {
  OldMap old(rows);
  old.need_head(
      [&](std::string_view body, std::int64_t, const std::string& where) { read_landmark_head(body, where, old); });
  old.read_keyframes(landmark_image, [](ByteReader& bytes) {
    OldPose pose;
    pose.submap = bytes.get<std::int32_t>();
    pose.parent = bytes.get<KeyframeId>();
    pose.world_from_camera = get_pose(bytes);
    return pose;
  });
  read_constraints(rows, "ties", landmark_constraint, *old.map);
  old.read_trajectory();
  auto landmarks = std::make_shared<LandmarkLayer>();
  rows.each("landmarks", [&](std::string_view body, std::int64_t id, const std::string& where) {
    ByteReader bytes(body, where);
    Landmark landmark = get_landmark(bytes, id);
    bytes.finish();
    landmarks->landmarks.push_back(std::move(landmark));
  });
  old.map->layers.put<LandmarkLayer>(std::move(landmarks));
  return old.map;
}

}  // namespace rastro
