// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/landmark_export.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/landmark_image.h"
#include "rastro/export/ply.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/scans/scan_layer.h"

namespace rastro {
namespace {

const Map& road() {
  static const Map map = make_landmark_test_map();
  return map;
}

const std::vector<Landmark>& road_landmarks() { return road().layer<LandmarkLayer>()->landmarks; }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (!line.starts_with('#')) lines.push_back(line);
  return lines;
}

std::vector<double> numbers_of(const std::string& line) {
  std::vector<double> numbers;
  std::istringstream stream(line);
  for (double value; stream >> value;) numbers.push_back(value);
  return numbers;
}

TEST(LandmarkColmap, PointsOfTheTextReprojectOntoTheirImages) {
  const auto folder = scratch_path("colmap");
  write_landmark_colmap(road(), folder, ColmapForm::text, 0);
  const auto images = lines_of(read_whole_file(folder / "images.txt"));
  const auto points = lines_of(read_whole_file(folder / "points3D.txt"));
  ASSERT_EQ(images.size(), 2 * road().keyframes.size());
  ASSERT_EQ(points.size(), road_landmarks().size());
  const auto point = numbers_of(points[7]);
  const Eigen::Vector3d position(point[1], point[2], point[3]);
  EXPECT_NEAR(point[7], 0.0, 1e-3) << "an exact map";
  for (std::size_t i = 8; i + 1 < point.size(); i += 2) {
    std::size_t row = 0;
    while (row < images.size() && numbers_of(images[row])[0] != point[i]) row += 2;
    ASSERT_LT(row, images.size());
    const auto pose = numbers_of(images[row]), seen = numbers_of(images[row + 1]);
    const Eigen::Quaterniond q(pose[1], pose[2], pose[3], pose[4]);
    const Eigen::Vector3d in_camera = q * position + Eigen::Vector3d(pose[5], pose[6], pose[7]);
    const auto at = static_cast<std::size_t>(point[i + 1]) * 3;
    const Camera camera = TestRoad::camera();
    EXPECT_NEAR(camera.fx * in_camera.x() / in_camera.z() + camera.cx + 0.5, seen[at], 0.01);
    EXPECT_NEAR(camera.fy * in_camera.y() / in_camera.z() + camera.cy + 0.5, seen[at + 1], 0.01);
    EXPECT_EQ(seen[at + 2], point[0]);
  }
}

/// Reads COLMAP's binary files by their published layout.
class Bytes {
 public:
  explicit Bytes(std::string bytes) : bytes_(std::move(bytes)) {}
  template <typename Number>
  Number get() {
    Number number{};
    EXPECT_LE(at_ + sizeof number, bytes_.size());
    std::memcpy(&number, bytes_.data() + at_, sizeof number);
    at_ += sizeof number;
    return number;
  }
  std::string text() {
    const std::string text = bytes_.c_str() + at_;
    at_ += text.size() + 1;
    return text;
  }
  bool ended() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

TEST(LandmarkColmap, TheBinaryFilesSayTheSame) {
  const auto folder = scratch_path("colmap_binary");
  write_landmark_colmap(road(), folder, ColmapForm::binary, 0);
  Bytes cameras(read_whole_file(folder / "cameras.bin"));
  EXPECT_EQ(cameras.get<std::uint64_t>(), 1U);
  EXPECT_EQ(cameras.get<std::uint32_t>(), 1U);
  EXPECT_EQ(cameras.get<std::int32_t>(), 1) << "PINHOLE";
  EXPECT_EQ(cameras.get<std::uint64_t>(), 640U);
  EXPECT_EQ(cameras.get<std::uint64_t>(), 480U);
  for (const double value : {400.0, 400.0, 320.0, 240.0}) EXPECT_EQ(cameras.get<double>(), value);
  EXPECT_TRUE(cameras.ended());
  Bytes images(read_whole_file(folder / "images.bin"));
  ASSERT_EQ(images.get<std::uint64_t>(), road().keyframes.size());
  std::size_t with_point = 0;
  for (const auto& keyframe : road().keyframes) {
    const Features& features = road().layer<FeatureLayer>()->find(keyframe.id)->features;
    EXPECT_EQ(images.get<std::uint32_t>(), *road().index_of(keyframe.id) + 1);
    for (int i = 0; i < 7; ++i) images.get<double>();
    EXPECT_EQ(images.get<std::uint32_t>(), 1U);
    EXPECT_EQ(images.text().size(), std::string("000000.png").size());
    ASSERT_EQ(images.get<std::uint64_t>(), features.size());
    for (std::size_t i = 0; i < features.size(); ++i) {
      EXPECT_NEAR(images.get<double>(), features.keypoints[i].x + 0.5, 1e-9);
      images.get<double>();
      with_point += images.get<std::uint64_t>() != std::uint64_t(-1) ? 1 : 0;
    }
  }
  EXPECT_TRUE(images.ended());
  Bytes points(read_whole_file(folder / "points3D.bin"));
  ASSERT_EQ(points.get<std::uint64_t>(), road_landmarks().size());
  std::size_t tracked = 0;
  for (const Landmark& landmark : road_landmarks()) {
    EXPECT_EQ(points.get<std::uint64_t>(), landmark.id + 1);
    for (const double value : landmark.position) EXPECT_EQ(points.get<double>(), value);
    for (int i = 0; i < 3; ++i) points.get<std::uint8_t>();
    EXPECT_LT(points.get<double>(), 1e-3);
    const auto length = points.get<std::uint64_t>();
    ASSERT_EQ(length, landmark.observations.size());
    for (std::uint64_t i = 0; i < 2 * length; ++i) points.get<std::uint32_t>();
    tracked += length;
  }
  EXPECT_TRUE(points.ended());
  EXPECT_EQ(tracked, with_point);
}

/// The id of a keyframe of a later session is beyond COLMAP's 32 bits.
TEST(LandmarkColmap, ImagesAreNumberedInTheirOrder) {
  Map map = road();
  auto landmarks = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  auto features = std::make_shared<FeatureLayer>(*map.layer<FeatureLayer>());
  const KeyframeId last = map.keyframes.back().id, later = keyframe_id({0, 1, 0});
  map.keyframes.back().id = later;
  for (Landmark& landmark : landmarks->landmarks)
    for (LandmarkObservation& each : landmark.observations)
      if (each.keyframe == last) each.keyframe = later;
  auto moved = features->of.extract(last);
  moved.key() = later;
  features->of.insert(std::move(moved));
  map.layers.put<LandmarkLayer>(std::move(landmarks));
  map.layers.put<FeatureLayer>(std::move(features));
  const auto folder = scratch_path("colmap_sessions");
  write_landmark_colmap(map, folder, ColmapForm::text, 0);
  const auto images = lines_of(read_whole_file(folder / "images.txt"));
  for (std::size_t row = 0; row + 1 < images.size(); row += 2)
    EXPECT_EQ(numbers_of(images[row])[0], static_cast<double>(row / 2 + 1));
  const auto size = static_cast<double>(map.keyframes.size());
  double largest = 0.0;
  for (const std::string& line : lines_of(read_whole_file(folder / "points3D.txt"))) {
    const auto numbers = numbers_of(line);
    for (std::size_t i = 8; i + 1 < numbers.size(); i += 2) largest = std::max(largest, numbers[i]);
  }
  EXPECT_EQ(largest, size);
}

TEST(LandmarkColmap, ImagesHaveTheirNamesAndLandmarksSeenOnceAreLeftOut) {
  Map map = road();
  auto landmarks = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  const KeyframeId lonely = landmarks->landmarks[5].observations.front().keyframe;
  landmarks->landmarks[5].observations.resize(1);
  map.layers.put<LandmarkLayer>(landmarks);
  const auto folder = scratch_path("colmap_names");
  const ColmapNames names = {{lonely, "1403715285262142976.png"}};
  const ColmapSize size = write_landmark_colmap(map, folder, ColmapForm::text, 0, names);
  EXPECT_EQ(size.images, map.keyframes.size());
  EXPECT_EQ(size.points, landmarks->landmarks.size() - 1);
  for (const std::string& line : lines_of(read_whole_file(folder / "points3D.txt"))) {
    EXPECT_GE(numbers_of(line).size(), 8U + 2U * 2U) << "a track of two images";
    EXPECT_NE(static_cast<std::int64_t>(numbers_of(line)[0]), landmarks->landmarks[5].id + 1);
  }
  const auto images = lines_of(read_whole_file(folder / "images.txt"));
  const std::string absent = " " + std::to_string(landmarks->landmarks[5].id + 1);
  for (std::size_t row = 0; row + 1 < images.size(); row += 2) {
    const bool named = static_cast<std::size_t>(numbers_of(images[row])[0]) == *map.index_of(lonely) + 1;
    EXPECT_EQ(images[row].ends_with(" 1403715285262142976.png"), named) << images[row];
    const auto features = numbers_of(images[row + 1]);
    for (std::size_t i = 2; i < features.size(); i += 3) EXPECT_NE(" " + fmt::format("{:.0f}", features[i]), absent);
  }
}

std::set<std::string> colmap_image_names(const Map& map, const ColmapNames& names) {
  const auto folder = scratch_path("colmap_unnamed");
  write_landmark_colmap(map, folder, ColmapForm::text, 0, names);
  const auto images = lines_of(read_whole_file(folder / "images.txt"));
  std::set<std::string> found;
  for (std::size_t row = 0; row < images.size(); row += 2) found.insert(images[row].substr(images[row].rfind(' ') + 1));
  return found;
}

/// COLMAP takes two images of one name for one.
TEST(LandmarkColmap, NoTwoImagesHaveOneName) {
  Map map = road();
  const ColmapNames names = {{map.keyframes[2].id, fmt::format("{:06}.png", map.keyframes[5].frame)}};
  EXPECT_EQ(colmap_image_names(map, names).size(), map.keyframes.size()) << "the files have other numbers";
  map.sessions.resize(2);
  map.keyframes[4].frame = map.keyframes[3].frame;
  const std::set<std::string> found = colmap_image_names(map, {});
  EXPECT_EQ(found.size(), map.keyframes.size());
  EXPECT_TRUE(found.contains(fmt::format("keyframe{}_{:06}.png", map.keyframes[4].id, map.keyframes[4].frame)));
}

TEST(LandmarkExport, AnotherSubmapIsLeftOutUnlessAskedFor) {
  Map map = road();
  for (std::size_t k = 6; k < map.keyframes.size(); ++k) map.keyframes[k].submap = 1;
  map.keyframes[6].parent = no_keyframe;
  const std::size_t all = road_landmarks().size();
  const std::size_t first = lines_of(landmark_list_csv(map, 0)).size() - 1;
  const std::size_t second = lines_of(landmark_list_csv(map, 1)).size() - 1;
  EXPECT_EQ(lines_of(landmark_list_csv(map, -1)).size() - 1, all);
  EXPECT_LT(first, all);
  EXPECT_GE(first + second, all) << "some are observed from both";
}

TEST(LandmarkExport, PointsComeFromAllLayersOfASubmap) {
  Map map = road();
  map.keyframes.back().submap = 1;
  ScanLayer scans;
  scans.of[map.keyframes.back().id] = std::make_shared<KeyframeScans>(KeyframeScans{{{0.0, 0.0}, {{1.0, 2.0}}}});
  map.layers.put<ScanLayer>(std::make_shared<ScanLayer>(scans));
  const std::size_t all = layer_points(map, -1).points.size();
  EXPECT_EQ(all, road_landmarks().size() + 1);
  EXPECT_EQ(layer_points(map, 0).points.size() + layer_points(map, 1).points.size(), all);
  const Eigen::Vector3d expected = map.keyframes.back().world_from_camera * Eigen::Vector3d(1.0, 2.0, 0.0);
  EXPECT_LT((layer_points(map, 1).points.back().position.cast<double>() - expected).norm(), 1e-5);
}

TEST(LandmarkExport, TheCloudIsAPlyAndTheGraphHasPosesThatAgreeWithItsEdges) {
  const PointCloud cloud = parse_cloud_ply(cloud_ply(layer_points(road(), 0), "frame"), "ply");
  ASSERT_EQ(cloud.points.size(), road_landmarks().size());
  EXPECT_EQ(cloud.points[3].count, road_landmarks()[3].observations.size());
  EXPECT_GT(cloud.points[3].sigma, 0.0F);
  std::map<int, SE3> poses;
  std::size_t edges = 0;
  const auto pose_of = [](const std::vector<double>& v, std::size_t from) {
    return SE3(SO3(Eigen::Quaterniond(v[from + 6], v[from + 3], v[from + 4], v[from + 5])),
               {v[from], v[from + 1], v[from + 2]});
  };
  for (const std::string& line : lines_of(landmark_graph_g2o(road(), 0))) {
    const auto v = numbers_of(line.substr(line.find(' ')));
    if (line.starts_with("VERTEX")) poses[static_cast<int>(v[0])] = pose_of(v, 1);
    if (!line.starts_with("EDGE")) continue;
    const SE3 expected = poses.at(static_cast<int>(v[0])).inverse() * poses.at(static_cast<int>(v[1]));
    EXPECT_LT((expected.inverse() * pose_of(v, 2)).log().norm(), 1e-5) << "pixels are floats";
    ASSERT_EQ(v.size(), 2U + 7U + 21U);
    ++edges;
  }
  EXPECT_EQ(poses.size(), road().keyframes.size());
  EXPECT_EQ(edges, essential_graph(road()).size());
}

/// Edges of a g2o text: pose and diagonal of the information.
struct Edge {
  SE3 pose;
  Vector6d diagonal;
};
std::map<std::pair<KeyframeId, KeyframeId>, Edge> edges_of(const std::string& text) {
  std::map<std::pair<KeyframeId, KeyframeId>, Edge> edges;
  for (const std::string& line : lines_of(text)) {
    if (!line.starts_with("EDGE")) continue;
    const auto v = numbers_of(line.substr(line.find(' ')));
    Edge& edge = edges[{static_cast<KeyframeId>(v[0]), static_cast<KeyframeId>(v[1])}];
    edge.pose = SE3(SO3(Eigen::Quaterniond(v[8], v[5], v[6], v[7])), {v[2], v[3], v[4]});
    for (std::size_t row = 0, at = 9; row < 6; at += 6 - row, ++row) edge.diagonal[static_cast<int>(row)] = v[at];
  }
  return edges;
}

TEST(LandmarkG2o, EdgesAreMeasuredByLandmarksAndDoNotFollowTheNodes) {
  Map map = road();
  const auto before = edges_of(landmark_graph_g2o(map, 0));
  const Keyframe ground_truth = map.keyframes[5];
  const SE3 off = SE3::exp((Vector6d() << 0.05, -0.02, 0.03, 0.004, 0.01, -0.003).finished());
  map.keyframes[5].world_from_camera = ground_truth.world_from_camera * off;
  const auto after = edges_of(landmark_graph_g2o(map, 0));
  ASSERT_EQ(after.size(), before.size());
  int into = 0;
  for (const auto& [ends, edge] : after) {
    const SE3 change = before.at(ends).pose.inverse() * edge.pose;
    if (ends.second == ground_truth.id) {
      EXPECT_LT(change.log().norm(), 1e-5) << "the landmarks are where they were";
      ++into;
    } else if (ends.first != ground_truth.id) {
      EXPECT_LT(change.log().norm(), 1e-12);
    }
  }
  EXPECT_GE(into, 1);
}

TEST(LandmarkG2o, InformationIsThatOfThePixels) {
  const Map& map = road();
  const auto edges = edges_of(landmark_graph_g2o(map, 0));
  const std::pair<KeyframeId, KeyframeId> ends{map.keyframes[3].id, map.keyframes[4].id};
  ASSERT_TRUE(edges.contains(ends));
  const std::vector<double> scales = orb_level_scales(map.layer<FeatureLayer>()->extraction);
  const ImageFeatures& image = *map.layer<FeatureLayer>()->find(ends.second);
  const SE3 camera_from_world = map.keyframes[4].world_from_camera.inverse();
  double expected = 0.0;  // of a shift along x, by differences
  for (const Landmark& landmark : road_landmarks()) {
    const auto sees = [&](KeyframeId id) {
      return std::find_if(landmark.observations.begin(), landmark.observations.end(),
                          [id](const LandmarkObservation& each) { return each.keyframe == id; });
    };
    if (sees(ends.first) == landmark.observations.end() || sees(ends.second) == landmark.observations.end()) continue;
    const double step = 1e-5, sigma = scales[image.features.levels[sees(ends.second)->feature]];
    const Eigen::Vector3d point = camera_from_world * landmark.position, shift(step, 0.0, 0.0);
    const auto here = TestRoad::camera().project(point), there = TestRoad::camera().project(point - shift);
    expected += (*there - *here).squaredNorm() / (step * step * sigma * sigma);
  }
  EXPECT_NEAR(edges.at(ends).diagonal[0], expected, 1e-3 * expected);
}

TEST(LandmarkG2o, FewSharedLandmarksAreSaid) {
  Map map = road();
  auto landmarks = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  landmarks->landmarks.resize(5);
  map.layers.put<LandmarkLayer>(landmarks);
  GraphSize size;
  const std::string text = landmark_graph_g2o(map, 0, &size);
  EXPECT_THAT(text, testing::HasSubstr("\n# the next edge is not measured"));
  EXPECT_EQ(size.vertices, map.keyframes.size());
  EXPECT_EQ(size.edges, edges_of(text).size());
}

TEST(LandmarkExport, SaysTheUnitAndThatASigmaIsNotKnown) {
  Map map = road();
  auto landmarks = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  landmarks->landmarks[2].observations.resize(1);
  map.layers.put<LandmarkLayer>(landmarks);
  const CloudTerms terms{"arbitrary units", "observations", "the position along the mean viewing direction"};
  const std::string ply = cloud_ply(layer_points(map, 0), "world", terms);
  EXPECT_THAT(ply, testing::HasSubstr("lengths in arbitrary units;"));
  EXPECT_THAT(ply, testing::HasSubstr("comment count: observations; sigma: standard deviation of the position along "
                                      "the mean viewing direction, arbitrary units; nan: unknown\n"));
  EXPECT_EQ(ply.substr(0, ply.find("end_header")).find("meters"), std::string::npos);
  const auto sigma_at = [&](std::size_t point) {
    float sigma = 0.0F;
    std::memcpy(&sigma, ply.data() + ply.find("end_header\n") + 11 + 35 * point + 31, sizeof sigma);
    return sigma;
  };
  EXPECT_TRUE(std::isnan(sigma_at(2)));
  EXPECT_GT(sigma_at(3), 0.0F);
  EXPECT_EQ(parse_cloud_ply(ply, "ply").points[2].sigma, 0.0F);
  const auto rows = lines_of(landmark_list_csv(map, 0));
  EXPECT_THAT(rows[1 + 2], testing::HasSubstr(",,1,")) << "sigma is empty, one observation";
  EXPECT_THAT(rows[1 + 3], testing::Not(testing::HasSubstr(",,")));
  EXPECT_THAT(landmark_graph_g2o(map, 0),
              testing::StartsWith("# written by rastro: world_from_camera of keyframes, arbitrary units;"));
}

TEST(LandmarkImage, IsDrawnAsBothKindsAndOfAnEmptyMap) {
  const auto svg = scratch_path("road.svg"), png = scratch_path("road.png");
  write_landmark_image(road(), svg.string());
  write_landmark_image(road(), png.string());
  const std::string text = read_whole_file(svg);
  EXPECT_THAT(text, testing::AllOf(testing::StartsWith("<svg"), testing::EndsWith("</svg>\n")));
  std::size_t red_lines = 0;
  for (auto at = text.find("#dc2828"); at != std::string::npos; at = text.find("#dc2828", at + 1)) ++red_lines;
  EXPECT_EQ(red_lines, 1U) << "one loop closure";
  EXPECT_EQ(read_whole_file(png).substr(1, 3), "PNG");
  write_landmark_image(Map(), svg.string());
  EXPECT_THROW(write_landmark_image(road(), scratch_path("road.bmp").string()), Error);
}

}  // namespace
}  // namespace rastro
