// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/export/cloud_image.h"
#include "rastro/export/cloud_pcd.h"
#include "rastro/export/colmap.h"
#include "rastro/export/ply.h"
#include "rastro/export/pose_graph_g2o.h"
#include "rastro/export/pose_text.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

using testing::HasSubstr;

PointCloud three_points() {
  PointCloud cloud;
  cloud.voxel_m = 0.01;
  for (int k = 0; k < 3; ++k) {
    CloudPoint point;
    point.position = {0.5F + static_cast<float>(k), -1.25F, 1e-3F};
    point.normal = {0.0F, 0.6F, -0.8F};
    point.color = {static_cast<std::uint8_t>(10 + k), 128, 255};
    point.count = 70000U + static_cast<std::uint32_t>(k);
    point.sigma = 0.0025F;
    cloud.points.push_back(point);
  }
  return cloud;
}

void expect_same(const PointCloud& a, const PointCloud& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t k = 0; k < a.points.size(); ++k) {
    EXPECT_EQ(a.points[k].position, b.points[k].position);
    EXPECT_EQ(a.points[k].normal, b.points[k].normal);
    EXPECT_EQ(a.points[k].color, b.points[k].color);
    EXPECT_EQ(a.points[k].count, b.points[k].count);
    EXPECT_EQ(a.points[k].sigma, b.points[k].sigma);
  }
}

std::string message_of(const std::string& bytes) {
  try {
    parse_mesh_ply(bytes, "a.ply");
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(Ply, ReadsBackTheCloudItWrites) {
  const std::string bytes = cloud_ply(three_points(), "the first\ncamera");
  EXPECT_THAT(
      bytes, testing::StartsWith("ply\nformat binary_little_endian 1.0\ncomment written by rastro; lengths in meters"));
  EXPECT_EQ(bytes.size() - bytes.find("end_header\n") - 11, 3U * 35U);
  expect_same(parse_cloud_ply(bytes, "a.ply"), three_points());
}

TEST(Ply, IsTheSameInPieces) {
  PointCloud cloud = three_points();
  while (cloud.points.size() < 30000) cloud.points.push_back(cloud.points[cloud.points.size() - 3]);
  std::string bytes;
  std::size_t pieces = 0, longest = 0;
  cloud_ply(cloud, "world", {}, [&](std::string_view piece) {
    bytes += piece;
    longest = std::max(longest, piece.size());
    ++pieces;
  });
  EXPECT_TRUE(bytes == cloud_ply(cloud, "world"));
  EXPECT_GT(pieces, 3U);
  EXPECT_LT(longest, 300'000U);
}

TEST(Ply, ReadsWhatOthersWrite) {
  const std::string text =
      "ply\r\nformat ascii 1.0\r\nelement camera 1\r\nproperty double f\r\nelement vertex 4\r\nproperty double z\r\n"
      "property double x\r\nproperty float y\r\nproperty float quality\r\nelement face 1\r\nproperty uchar flags\r\n"
      "property list uchar int vertex_index\r\nend_header\r\n7\r\n3 1 2 0\n3 4 2 0\n3 4 5 0\nnan 1 5 0\n9 3 0 1 2\n";
  const PointCloud cloud = parse_cloud_ply(text, "a.ply");
  ASSERT_EQ(cloud.points.size(), 3U);
  EXPECT_EQ(cloud.points[2].position, Eigen::Vector3f(4, 5, 3));
  const TriangleMesh mesh = parse_mesh_ply(text, "a.ply");
  EXPECT_EQ(mesh.vertices.size(), 4U);
  EXPECT_THAT(mesh.triangles, testing::ElementsAre(std::array<std::uint32_t, 3>{0, 1, 2}));
}

/// As the Point Cloud Library writes points beside a hole.
TEST(Ply, APointWithoutANormalStays) {
  const PointCloud cloud = parse_cloud_ply(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\nend_header\n1 2 3 nan nan nan\n4 5 6 0 0 1\n",
      "a.ply");
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[0].position, Eigen::Vector3f(1, 2, 3));
  EXPECT_TRUE(cloud.points[0].normal.isZero());
  EXPECT_EQ(cloud.points[1].normal, Eigen::Vector3f(0, 0, 1));
}

TEST(Ply, ReadsBackTheMeshItWrites) {
  TriangleMesh mesh;
  for (int k = 0; k < 4; ++k)
    mesh.vertices.push_back(
        {{static_cast<float>(k), 0.5F, 2.0F}, {0.0F, 0.0F, 1.0F}, {1, 2, static_cast<std::uint8_t>(k)}});
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
  const TriangleMesh back = parse_mesh_ply(mesh_ply(mesh, "world"), "a.ply");
  EXPECT_EQ(back.triangles, mesh.triangles);
  ASSERT_EQ(back.vertices.size(), 4U);
  EXPECT_EQ(back.vertices[3].position, mesh.vertices[3].position);
  EXPECT_EQ(back.vertices[3].color, mesh.vertices[3].color);
}

TEST(Ply, RefusesWhatIsNoneInOneLine) {
  const std::string sound = cloud_ply(three_points(), "");
  EXPECT_THAT(message_of(sound.substr(0, sound.size() - 1)), HasSubstr("ends early"));
  EXPECT_THAT(message_of(sound.substr(0, 90)), HasSubstr("end_header"));
  EXPECT_THAT(message_of("pcd\n"), HasSubstr("a.ply"));
  EXPECT_THAT(message_of("ply\nformat ascii 1.0\nelement vertex 99999999999999\nend_header\n"), HasSubstr("count"));
  EXPECT_THAT(message_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("x, y, z"));
  EXPECT_THAT(message_of("ply\nformat ascii 1.0\nproperty float x\nend_header\n"), HasSubstr("of nothing"));
  EXPECT_THAT(message_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty word x\nend_header\n"), HasSubstr("type"));
  EXPECT_THAT(message_of("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
                         "3 0 1 2\n"),
              HasSubstr("missing vertex"));
}

TEST(Pcd, HasTheFieldsOfThePointCloudLibrary) {
  const std::string bytes = cloud_pcd(three_points(), "x");
  EXPECT_THAT(bytes, HasSubstr("\nFIELDS x y z normal_x normal_y normal_z rgb count sigma\nSIZE 4 4 4 4 4 4 4 4 4\n"));
  EXPECT_THAT(bytes, HasSubstr("\nWIDTH 3\nHEIGHT 1\n"));
  const std::string body = bytes.substr(bytes.find("DATA binary\n") + 12);
  ASSERT_EQ(body.size(), 3U * 36U);
  std::uint32_t rgb = 0;
  std::memcpy(&rgb, body.data() + 36 + 24, 4);
  EXPECT_EQ(rgb, 0x0B80FFU);
  EXPECT_THAT(bytes,
              HasSubstr("lengths in meters; x\n# count: measurements; sigma: standard deviation of the position"));
  PointCloud unknown = three_points();
  unknown.points[0].sigma = 0.0F;
  const std::string other = cloud_pcd(unknown, "x", {"arbitrary units", "observations", "y"});
  EXPECT_THAT(other, HasSubstr("lengths in arbitrary units;"));
  float sigma = 0.0F;
  std::memcpy(&sigma, other.data() + other.find("DATA binary\n") + 12 + 32, 4);
  EXPECT_TRUE(std::isnan(sigma));
}

TEST(G2o, HasPosesMeasurementsAndTheInformationOfRotationsByPi) {
  Map map = make_test_map(3);
  map.constraints[1].weight = 0.0;
  map.constraints[0].weight = 0.5;
  map.constraints[0].information(0, 4) = map.constraints[0].information(4, 0) = 10.0;
  const std::string text = pose_graph_g2o(map);
  EXPECT_THAT(text, HasSubstr("FIX 0\n"));
  EXPECT_THAT(text, HasSubstr("# switched off: EDGE_SE3:QUAT 1 2 "));
  const std::string edge = text.substr(text.find("EDGE_SE3:QUAT 0 1"));
  const std::string line = edge.substr(0, edge.find('\n'));
  const auto words = split_words(line);
  ASSERT_EQ(words.size(), 3U + 7U + 21U);
  const auto number = [&](std::size_t k) { return parse_double(words[k]).value_or(-1.0); };
  const SE3 measured = map.constraints[0].rigid();
  EXPECT_NEAR(number(3), measured.translation().x(), 1e-7);
  EXPECT_NEAR(number(9), measured.rotation().quaternion().w(), 1e-7);
  EXPECT_DOUBLE_EQ(number(10), 0.5 * 1e4);
  EXPECT_DOUBLE_EQ(number(14), 0.5 * 2.0 * 10.0) << "row x, column of the rotation about y";
  EXPECT_DOUBLE_EQ(number(25), 0.5 * 4.0 * 4e4) << "upper triangle: 6 + 5 + 4 numbers come before";
}

TEST(G2o, HoldsOneSubmapOrAll) {
  Map map = make_test_map(4);
  map.keyframes[2].submap = map.keyframes[3].submap = 1;
  GraphSize one, all;
  const std::string text = pose_graph_g2o(map, 1, &one);
  EXPECT_EQ(text.find("VERTEX_SE3:QUAT 1 "), std::string::npos);
  EXPECT_THAT(text, HasSubstr("FIX 2\n"));
  pose_graph_g2o(map, -1, &all);
  EXPECT_EQ(one.vertices, 2U);
  EXPECT_EQ(all.vertices, 4U);
  EXPECT_LT(one.edges, all.edges);
  map.sessions.assign(1, {});
  EXPECT_THAT(pose_graph_g2o(map), HasSubstr("arbitrary units"));
}

TEST(PoseText, IsReadBack) {
  const Trajectory trajectory = trajectory_of(make_test_map(3));
  const Trajectory euroc = parse_euroc_trajectory(euroc_text(trajectory), "e");
  const auto kitti = parse_kitti_poses(kitti_text(trajectory), "k");
  const auto times = parse_kitti_times(kitti_times_text(trajectory), "t");
  ASSERT_EQ(euroc.size(), trajectory.size());
  ASSERT_EQ(kitti.size(), trajectory.size());
  for (std::size_t k = 0; k < euroc.size(); ++k) {
    const auto& [stamp, pose] = trajectory[k];
    EXPECT_EQ(euroc[k].stamp, stamp);
    EXPECT_EQ(times[k], stamp);
    EXPECT_LT((euroc[k].world_from_body.inverse() * pose).log().norm(), 1e-7);
    EXPECT_LT((kitti[k].inverse() * pose).log().norm(), 1e-7);
  }
}

TEST(Colmap, HasPixelsAtHalvesAndPointsThatProjectThere) {
  const auto folder = scratch_folder("colmap");
  Map map = make_test_map(3);
  write_colmap(map, folder);
  EXPECT_THAT(read_text_file((folder / "cameras.txt").string()), HasSubstr("1 PINHOLE 320 240 260 260 160 120\n"));
  EXPECT_EQ(cv::imread((folder / "images" / "000002.jpg").string()).cols, 320);
  const std::string images = read_text_file((folder / "images.txt").string());
  const std::string points = read_text_file((folder / "points3D.txt").string());
  const auto lines = content_lines(points);
  ASSERT_GT(lines.size(), 10U);
  const auto words = split_words(lines[0].text);
  const std::size_t keyframe = static_cast<std::size_t>(*parse_int64(words[8])) - 1;
  const std::size_t feature = static_cast<std::size_t>(*parse_int64(words[9]));
  const auto number = [](std::string_view word) { return parse_double(word).value(); };
  const Eigen::Vector3d position(number(words[1]), number(words[2]), number(words[3]));
  const auto image = split_words(content_lines(images)[2 * keyframe].text);
  const SE3 camera_from_world(
      SO3(Eigen::Quaterniond(number(image[1]), number(image[2]), number(image[3]), number(image[4]))),
      {number(image[5]), number(image[6]), number(image[7])});
  const auto pixel = map.cameras[0].intrinsics.project(camera_from_world * position);
  const auto features = split_words(content_lines(images)[2 * keyframe + 1].text);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x() + 0.5, number(features[3 * feature]), 8.0);
  EXPECT_EQ(number(features[3 * feature + 2]), 1.0);
  map.cameras.push_back(map.cameras[0]);
  map.cameras[1].intrinsics.distortion = Distortion::radial_tangential;
  map.cameras[1].intrinsics.coefficients = {0.1, -0.2, 0.001, 0.002, 0.3};
  EXPECT_THAT(colmap_cameras(map.cameras),
              HasSubstr("\n2 FULL_OPENCV 320 240 260 260 160 120 0.1 -0.2 0.001 0.002 0.3 0 0 0"));
  map.cameras[1].intrinsics.distortion = Distortion::rational;
  map.cameras[1].intrinsics.coefficients[6] = 0.4;
  EXPECT_THAT(colmap_cameras(map.cameras),
              HasSubstr("\n2 FULL_OPENCV 320 240 260 260 160 120 0.1 -0.2 0.001 0.002 0.3 0 0.4 0"));
}

/// As in a map that was recovered from a damaged file.
TEST(Colmap, AKeyframeWithoutAnImageIsLeftOut) {
  const auto folder = scratch_folder("colmap_recovered");
  Map map = make_test_map(3);
  auto store = std::make_shared<MemoryImages>();
  for (const KeyframeId id : {0, 2}) store->add(id, images_of(map)->read(id));
  auto images = std::make_shared<ImageLayer>(*map.layer<ImageLayer>());
  images->store = store, images->keyframes = {0, 2};
  map.layers.put<ImageLayer>(std::move(images));
  EXPECT_EQ(write_colmap(map, folder), 2U);
  EXPECT_FALSE(std::filesystem::exists(folder / "images" / "000001.jpg"));
  const std::string text = read_text_file((folder / "images.txt").string());
  const auto lines = content_lines(text);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_TRUE(lines[0].text.starts_with("1 "));
  EXPECT_TRUE(lines[2].text.starts_with("3 "));
}

TEST(CloudImage, ShowsTheRoomFromAboveWithoutItsCeiling) {
  const Map map = make_test_map(4);
  CloudOptions options;
  options.voxel_m = 0.02;
  const std::string file = (scratch_folder("cloud_image") / "map.png").string();
  write_cloud_image(build_cloud(map, options), trajectory_of(map), file);
  const cv::Mat image = cv::imread(file);
  ASSERT_FALSE(image.empty());
  EXPECT_LE(std::max(image.rows, image.cols), 1600);
  int blue = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& pixel = image.at<cv::Vec3b>(y, x);
      blue += pixel[0] > 2 * pixel[2] && pixel[0] > 60 && pixel[1] < pixel[0] / 2 ? 1 : 0;
    }
  EXPECT_GT(blue, 1000) << "the top of the box";
  write_cloud_image(PointCloud(), {}, file);
}

}  // namespace
}  // namespace rastro
