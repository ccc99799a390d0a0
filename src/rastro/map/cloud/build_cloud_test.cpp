// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/cloud/build_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/map/cloud/upright.h"
#include "rastro/map/cloud/voxel_table.h"
#include "rastro/map/features/feature_points.h"
#include "rastro/map/images/depth_surface.h"
#include "rastro/map/images/room_map_testing.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

/// Of the nearest wall or face of the box: distance, and normal pointing into the room.
struct Nearest {
  double distance = 1e9;
  Vector3d normal = Vector3d::Zero();
};

Nearest nearest_face(const Vector3d& point) {
  Nearest nearest;
  const auto consider = [&](double signed_distance, int axis, double side) {
    if (std::abs(signed_distance) < std::abs(nearest.distance))
      nearest = {signed_distance, side * Vector3d::Unit(axis)};
  };
  for (int axis = 0; axis < 3; ++axis) {
    consider(point[axis] - test_room::low[axis], axis, 1.0);
    consider(test_room::high[axis] - point[axis], axis, -1.0);
  }
  const Vector3d outside = (test_room::box_low - point).cwiseMax(point - test_room::box_high);
  for (int axis = 0; axis < 3; ++axis) {
    const bool beside = outside[(axis + 1) % 3] < 0.0 && outside[(axis + 2) % 3] < 0.0;
    if (!beside) continue;
    consider(point[axis] - test_room::box_high[axis], axis, 1.0);
    consider(test_room::box_low[axis] - point[axis], axis, -1.0);
  }
  return nearest;
}

/// The map with these images instead of its own.
Map with_images(const Map& map, std::shared_ptr<const ImageStore> store) {
  Map result = map;
  auto images = std::make_shared<ImageLayer>(*map.layer<ImageLayer>());
  images->store = std::move(store);
  result.layers.put<ImageLayer>(std::move(images));
  return result;
}

/// The test map with the noise of its depth camera.
Map noisy_map(int keyframes) {
  const Map map = make_test_map(keyframes);
  const DepthNoise noise = map.cameras.front().depth_noise;
  auto images = std::make_shared<MemoryImages>();
  for (int k = 0; k < keyframes; ++k) {
    Frame frame = test_room::frame_from(map.keyframes[static_cast<std::size_t>(k)].world_from_camera);
    Random random(static_cast<std::uint64_t>(k) + 5);
    for (int y = 0; y < frame.depth.height(); ++y) {
      for (int x = 0; x < frame.depth.width(); ++x) {
        float& z = frame.depth.at(x, y);
        z += static_cast<float>(random.normal() * noise.sigma(static_cast<double>(z)));
      }
    }
    images->add(k, pack_images(frame));
  }
  return with_images(map, images);
}

CloudOptions dense() {
  CloudOptions options;
  options.stride = 1;
  options.voxel_m = 0.02;
  return options;
}

TEST(BuildCloud, LiesOnTheSurfacesOfARoomWithoutNoise) {
  const Map map = make_test_map(3);
  const PointCloud cloud = build_cloud(map, dense());
  ASSERT_GT(cloud.points.size(), 5000U);
  std::size_t box = 0;
  double off = 0.0;
  for (const CloudPoint& point : cloud.points) {
    const Nearest face = nearest_face(point.position.cast<double>());
    // Packed depth has steps of 0.2 mm; points of two walls share the voxels of a corner.
    EXPECT_LT(std::abs(face.distance), 0.02) << point.position.transpose();
    off += std::abs(face.distance);
    EXPECT_GE(point.count, 3U);
    const bool blue = point.color[2] > 2 * point.color[0];
    const Vector3d position = point.position.cast<double>();
    box += blue ? 1 : 0;
    const bool at_box = (position.array() > test_room::box_low.array() - 0.02).all() &&
                        (position.array() < test_room::box_high.array() + 0.02).all();
    EXPECT_TRUE(at_box || !blue) << position.transpose();
  }
  EXPECT_GT(box, 300U);
  EXPECT_LT(off / static_cast<double>(cloud.points.size()), 0.001);
}

TEST(BuildCloud, NoisySurfacesStayThinWithNormalsAndSigmasThatHold) {
  const PointCloud cloud = build_cloud(noisy_map(6), dense());
  ASSERT_GT(cloud.points.size(), 5000U);
  double squares = 0.0, angle_error = 0.0, off = 0.0;
  std::size_t flat = 0, outside = 0;
  for (const CloudPoint& point : cloud.points) {
    const Vector3d position = point.position.cast<double>();
    // Except at edges, where neither normal nor distance is that of one face.
    int near_faces = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const double wall : {test_room::low[axis], test_room::high[axis]})
        near_faces += std::abs(position[axis] - wall) < 0.15 ? 1 : 0;
    if (near_faces != 1 || (position - 0.5 * (test_room::box_low + test_room::box_high)).norm() < 0.8) continue;
    const Nearest face = nearest_face(position);
    const double share = face.distance / static_cast<double>(point.sigma);
    squares += share * share;
    outside += std::abs(share) > 3.0 ? 1 : 0;
    off += std::abs(face.distance);
    angle_error += std::acos(std::min(1.0, point.normal.cast<double>().dot(face.normal)));
    ++flat;
  }
  ASSERT_GT(flat, 3000U);
  const auto count = static_cast<double>(flat);
  EXPECT_LT(std::sqrt(squares / count), 1.3) << "errors against their sigmas";
  EXPECT_GT(std::sqrt(squares / count), 0.2) << "sigmas are no mere fear";
  EXPECT_LT(static_cast<double>(outside) / count, 0.02);
  EXPECT_LT(off / count, 0.006) << "the noise of one measurement is 4 to 20 mm";
  EXPECT_LT(angle_error / count, 0.12) << "radians";
}

TEST(BuildCloud, CountsEveryMeasurementOnceIfNothingIsLeftOut) {
  const Map map = make_test_map(1);
  CloudOptions options = dense();
  options.voxel_m = 0.3;
  options.min_count = 1;
  options.grazing_deg = 89.9;
  const PointCloud cloud = build_cloud(map, options);
  std::uint64_t sum = 0;
  for (const CloudPoint& point : cloud.points) sum += point.count;
  // All pixels except the outermost ones and those along edges of the box.
  EXPECT_GT(sum, 318U * 238U * 97U / 100U);
}

std::string bytes_of(const PointCloud& cloud) {
  std::string bytes;
  for (const CloudPoint& p : cloud.points) {
    bytes.append(reinterpret_cast<const char*>(p.position.data()), 12);
    bytes.append(reinterpret_cast<const char*>(p.normal.data()), 12);
    bytes.append(reinterpret_cast<const char*>(&p.sigma), 4);
    bytes.append(reinterpret_cast<const char*>(p.color.data()), 3);
    bytes += std::to_string(p.count);
  }
  return bytes;
}

TEST(BuildCloud, GivesTheSameBytesForAnyPool) {
  const Map map = make_test_map(9);
  const std::string alone = bytes_of(build_cloud(map, CloudOptions()));
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    EXPECT_TRUE(bytes_of(build_cloud(map, CloudOptions(), &pool)) == alone) << threads;
  }
}

TEST(BuildCloud, CoarsensRatherThanGrowBeyondItsLimit) {
  const Map map = make_test_map(2);
  CloudOptions options = dense();
  options.max_voxels = 3000;
  const PointCloud cloud = build_cloud(map, options);
  EXPECT_LE(cloud.points.size(), 3000U);
  EXPECT_DOUBLE_EQ(cloud.voxel_m, 0.16);
  for (const CloudPoint& point : cloud.points)
    EXPECT_LT(std::abs(nearest_face(point.position.cast<double>()).distance), 0.08);
}

/// Where nothing is merged, how many keyframes are in memory does not matter.
TEST(BuildCloud, GivesTheSameBytesForAnyNumberOfKeyframesAtOnce) {
  const Map map = make_test_map(9);
  const std::string usual = bytes_of(build_cloud(map, CloudOptions()));
  for (const std::size_t at_once : {1U, 2U, 5U}) {
    CloudOptions options;
    options.keyframes_at_once = at_once;
    EXPECT_TRUE(bytes_of(build_cloud(map, options)) == usual) << at_once;
  }
}

TEST(BuildCloud, WithLessMemoryItHasFewerVoxelsAndKeyframesAtOnce) {
  const Map map = make_test_map(1);
  CloudOptions plenty;
  keep_within(std::size_t{4} << 30, map, plenty);
  EXPECT_EQ(plenty.max_voxels, CloudOptions().max_voxels);
  EXPECT_EQ(plenty.keyframes_at_once, CloudOptions().keyframes_at_once);
  CloudOptions before = plenty;
  for (std::size_t megabytes = 1000; megabytes > 0; megabytes -= std::max<std::size_t>(1, megabytes / 10)) {
    CloudOptions options;
    keep_within(megabytes * 1'000'000, map, options);
    EXPECT_LE(options.max_voxels, before.max_voxels) << megabytes;
    EXPECT_LE(options.keyframes_at_once, before.keyframes_at_once) << megabytes;
    before = options;
  }
  EXPECT_EQ(before.keyframes_at_once, 1U);
  EXPECT_EQ(before.max_voxels, std::size_t{1} << 14) << "less is no cloud";
}

TEST(BuildCloud, TakesOnlyTheSubmapAskedForAndNothingFromAnEmptyMap) {
  Map map = make_test_map(2);
  map.keyframes[1].submap = 1;
  CloudOptions options;
  options.submap = 2;
  EXPECT_TRUE(build_cloud(map, options).points.empty());
  options.submap = 1;
  const std::size_t one = build_cloud(map, options).points.size();
  options.submap = -1;
  EXPECT_GT(build_cloud(map, options).points.size(), one);
  EXPECT_TRUE(build_cloud(Map(), CloudOptions()).points.empty());
}

TEST(BuildCloud, RefusesAMapWithoutImagesAndSkipsKeyframesWithoutAny) {
  Map map = make_test_map(2);
  const std::size_t both = build_cloud(map, CloudOptions()).points.size();
  auto images = std::make_shared<ImageLayer>(*map.layer<ImageLayer>());
  images->keyframes = {1};
  map.layers.put<ImageLayer>(std::move(images));
  const std::size_t one = build_cloud(map, CloudOptions()).points.size();
  EXPECT_GT(one, 0U);
  EXPECT_LT(one, both);
  map.layers.put<ImageLayer>(nullptr);
  EXPECT_THROW(build_cloud(map, CloudOptions()), Error);
}

TEST(BuildCloud, RefusesDamagedImagesInOneLine) {
  auto images = std::make_shared<MemoryImages>();
  images->add(0, {{1, 2, 3}, {4, 5}});
  EXPECT_THROW(build_cloud(with_images(make_test_map(1), images), CloudOptions()), Error);
}

TEST(SurfaceSamples, LeaveOutEdgesOfDepthAndGrazingSurfaces) {
  UnpackedImages images;
  images.depth = DepthImage(64, 48);
  images.color.rgb = Image<std::uint8_t>(3 * 64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) images.depth.at(x, y) = x < 30 ? 1.0F : 2.0F;
  images.depth.at(50, 20) = 0.0F;
  Camera camera = test_room::camera();
  camera.cx = 31.5, camera.cy = 23.5;
  SurfaceOptions options;
  options.stride = 1;
  const auto samples = surface_samples(images, RayTable(camera, 64, 48), options);
  EXPECT_EQ(samples.size(), 62U * 46U - 2U * 46U - 1U) << "two columns beside the edge, and the hole";
  std::size_t unknown = 0;
  for (const SurfaceSample& sample : samples) {
    unknown += sample.normal_in_camera.isZero() ? 1 : 0;
    EXPECT_TRUE(sample.normal_in_camera.isZero() || -sample.normal_in_camera.z() > 0.99F);
  }
  EXPECT_EQ(unknown, 2U * 46U) << "beside the edge, in the blocks that it cuts";
}

TEST(Upright, FindsTheFloorOfARoomForAnyWorldOrientation) {
  Map map = make_test_map(6);
  const SE3 new_from_old(SO3::exp({0.7, -1.1, 0.4}), {3.0, -2.0, 1.0});
  Trajectory cameras;
  for (Keyframe& keyframe : map.keyframes) {
    keyframe.world_from_camera = new_from_old * keyframe.world_from_camera;
    cameras.push_back({0, keyframe.world_from_camera});
  }
  CloudOptions options;
  options.voxel_m = 0.04;
  const Upright upright = find_upright(build_cloud(map, options), cameras);
  EXPECT_TRUE(upright.floor_found);
  EXPECT_THAT(upright.found_by, testing::HasSubstr("1.20 m below"));
  const Vector3d up = upright.upright_from_world.rotation() * (new_from_old.rotation() * Vector3d::UnitZ());
  EXPECT_LT((up - Vector3d::UnitZ()).norm(), 0.003);
  const Vector3d first = upright.upright_from_world * cameras.front().world_from_body.translation();
  EXPECT_LT((first - Vector3d(0.0, 0.0, 1.2)).norm(), 0.005);
  EXPECT_FALSE(find_upright(PointCloud(), cameras).floor_found);
}

TEST(Upright, APointFarBelowIsNoFloor) {
  PointCloud cloud;
  for (int k = 0; k < 400; ++k) {
    CloudPoint& point = cloud.points.emplace_back();
    point.position = {0.1F * static_cast<float>(k % 20), 0.1F * static_cast<float>(k / 20), -1.2F};
    point.normal = {0.0F, 0.0F, 1.0F};
  }
  cloud.points.push_back(cloud.points.back());
  cloud.points.back().position.z() = -1e6F;
  Eigen::Matrix3d level;
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Upright upright = find_upright(cloud, {{0, SE3(SO3::from_matrix(level), Vector3d::Zero())}});
  EXPECT_TRUE(upright.floor_found);
  EXPECT_NEAR((upright.upright_from_world * Vector3d::Zero()).z(), 1.2, 1e-6);
}

/// Its image's upper edge is ahead then.
TEST(Upright, TheFirstCameraMayFaceTheFloor) {
  Eigen::Matrix3d level, downward;
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  downward << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  const SO3 turned = SO3::exp({0.0, 0.0, 2.0});
  Trajectory cameras{{0, SE3(turned * SO3::from_matrix(downward), Vector3d::Zero())}};
  for (int k = 1; k < 6; ++k) cameras.push_back({k, SE3(turned * SO3::from_matrix(level), Vector3d::Zero())});
  const SO3 upright_from_world = find_upright(PointCloud(), cameras).upright_from_world.rotation();
  const Vector3d ahead = upright_from_world * (cameras[0].world_from_body.rotation() * -Vector3d::UnitY());
  EXPECT_GT(ahead.x(), 0.9) << ahead.transpose();
}

TEST(FeaturePoints, MatchFeaturesOfOnePointInSeveralKeyframes) {
  const Map map = make_test_map(4);
  const std::vector<FeaturePoint> points = feature_points(map);
  ASSERT_GT(points.size(), 20U);
  for (const FeaturePoint& point : points) {
    ASSERT_GE(point.views.size(), 2U);
    EXPECT_LT(point.error_px, 8.0);
    for (std::size_t k = 1; k < point.views.size(); ++k)
      EXPECT_LT(point.views[k - 1].keyframe, point.views[k].keyframe);
  }
}

TEST(CloudOptions, OfAPairReachAsFarAsItsDepthIsPrecise) {
  Map map;
  EXPECT_EQ(cloud_options_for(map).max_depth_m, 5.0);
  map.cameras.push_back({CameraKind::depth, test_room::camera(), 0.0, {0.001, 0.0028}, SE3()});
  EXPECT_EQ(cloud_options_for(map).max_depth_m, 5.0) << "a depth camera does not see farther, whatever its noise";
  EXPECT_EQ(cloud_options_for(map).voxel_m, 0.01);
  // A pair of 0.54 m at 719 pixels, disparities to 0.3 pixels: 3 % are reached at 38 m.
  MapCamera& camera = map.cameras.front();
  camera.kind = CameraKind::stereo, camera.baseline = 0.54, camera.depth_noise = {0.0, 0.3 / (719 * 0.54)};
  const CloudOptions street = cloud_options_for(map);
  EXPECT_NEAR(camera.depth_noise.sigma(street.max_depth_m), 0.03 * street.max_depth_m, 1e-9);
  EXPECT_NEAR(street.max_depth_m, 38.8, 0.1);
  EXPECT_NEAR(street.voxel_m, 0.01 * street.max_depth_m / 5.0, 1e-12);
  camera.depth_noise = {0.0, 0.0};
  EXPECT_EQ(cloud_options_for(map).max_depth_m, 100.0);
}

TEST(VoxelTable, FindsWhatWasAddedAndConvertsPositionsBothWays) {
  detail::VoxelTable table(0.01);
  Random random(3);
  std::vector<std::uint64_t> keys;
  for (int k = 0; k < 20000; ++k) {
    detail::WorldSample sample;
    sample.point = Vector3d(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5));
    sample.ray = {0, 0, 1}, sample.sigma = 0.01F;
    keys.push_back(table.key_of(sample.point));
    const Vector3d inside = (sample.point - table.corner_of(keys.back())) / 0.01;
    EXPECT_TRUE((inside.array() > -1e-6).all() && (inside.array() < 1.0 + 1e-6).all());
    table.add(keys.back(), sample, 0);
  }
  for (const std::uint64_t key : keys) ASSERT_NE(table.find(key), nullptr);
  EXPECT_EQ(table.find(table.key_of({7, 7, 7})), nullptr);
  EXPECT_EQ(table.key_of({1e9, 0, 0}), 0U);
  EXPECT_EQ(table.key_of({std::nan(""), 0, 0}), 0U);
}

}  // namespace
}  // namespace rastro
