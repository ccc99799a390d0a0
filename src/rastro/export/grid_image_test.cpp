// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/grid_image.h"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/scratch_testing.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

cv::Mat drawn(const MapImage& image) {
  const std::string file = scratch_path("map.png").string();
  write_map_image(image, file);
  return cv::imread(file);
}

int pixels_like(const cv::Mat& image, const cv::Vec3b& color) {
  int count = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) count += image.at<cv::Vec3b>(y, x) == color ? 1 : 0;
  return count;
}

/// Free cells of 10 cm in 4 x 2 m with a wall along the top.
std::shared_ptr<const OccupancyGrid> hall() {
  auto grid = std::make_shared<OccupancyGrid>();
  grid->cell_m = 0.1;
  grid->width = 40;
  grid->height = 20;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x) grid->percent.set(x, y, y == 19 ? 100 : 0);
  return grid;
}

TEST(MapImage, PutsWallsAndPathWhereTheyAre) {
  MapImage image;
  image.grid = hall();
  image.path = {{0.5, 0.5}, {3.5, 0.5}};
  const cv::Mat drawing = drawn(image);
  // 4 x 2 m with half a meter around cell centers, 200 pixels a meter.
  const auto at = [&](double x, double y) {
    return drawing.at<cv::Vec3b>(drawing.rows - static_cast<int>((y + 0.45) * 200.0),
                                 static_cast<int>((x + 0.45) * 200.0));
  };
  EXPECT_NEAR(drawing.cols, 980, 2);
  EXPECT_NEAR(drawing.rows, 580, 2);
  EXPECT_EQ(at(2.0, 1.95), cv::Vec3b(0, 0, 0)) << "the wall is at the top";
  EXPECT_EQ(at(2.0, 1.5), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(at(2.0, 0.5), cv::Vec3b(200, 90, 0)) << "the path";
  EXPECT_EQ(at(0.5, 0.5), cv::Vec3b(0, 150, 0)) << "its start";
  EXPECT_EQ(at(3.5, 0.5), cv::Vec3b(0, 0, 220)) << "its end";
  EXPECT_EQ(at(-0.3, 1.0), cv::Vec3b(215, 215, 215)) << "beyond the map";
}

TEST(MapImage, DrawsLoopsLandmarksAndEllipses) {
  Map map;
  map.keyframes = {{0, 0, 0, 0, SE3({}, {0.5, 0.5, 0.0}), 0, no_keyframe, 1.0},
                   {7, 1, 1, 0, SE3({}, {3.5, 1.5, 0.0}), 0, 0, 1.0},
                   {8, 2, 2, 0, SE3({}, {9.5, 1.5, 0.0}), 1, no_keyframe, 1.0},
                   {9, 3, 3, 0, SE3({}, {0.5, 1.5, 0.0}), 0, 7, 1.0}};
  for (const auto& [to, kind] :
       {std::pair{9, ConstraintKind::loop}, std::pair{9, ConstraintKind::odometry}, std::pair{7, ConstraintKind::loop},
        std::pair{99, ConstraintKind::loop}, std::pair{8, ConstraintKind::loop}}) {
    map.constraints.emplace_back();
    map.constraints.back().to = to, map.constraints.back().kind = kind;
  }
  LandmarkLayer landmarks;
  landmarks.landmarks.resize(1);
  landmarks.landmarks[0].position = {2.0, 0.5, 0.0};
  landmarks.estimates.push_back({3, 1, 0.01 * Eigen::Matrix3d::Identity()});
  map.layers.put<LandmarkLayer>(std::make_shared<LandmarkLayer>(landmarks));
  MapImage image = map_image(map, hall(), {});
  EXPECT_EQ(image.keyframes.size(), 3U) << "another submap is left out";
  ASSERT_EQ(image.loops.size(), 1U)
      << "with no keyframe, with another submap, or straight ahead a loop closure is left out";
  EXPECT_EQ(image.loops[0].second, Eigen::Vector2d(0.5, 1.5));
  const cv::Mat with = drawn(image);
  EXPECT_GT(pixels_like(with, {190, 0, 190}), 30);
  image.loops.clear();
  image.landmarks.clear();
  EXPECT_EQ(pixels_like(drawn(image), {190, 0, 190}), 0);
  EXPECT_GT(cv::norm(with, drawn(image), cv::NORM_L1), 0.0);
}

TEST(MapImage, LoopsHideNeitherMapNorWalls) {
  MapImage image;
  image.grid = hall();
  const cv::Mat without = drawn(image);
  for (int k = 0; k < 1000; ++k) image.loops.push_back({{1.0, 0.2 + 1e-4 * k}, {3.0, 1.9 + 1e-4 * k}});
  image.loops.push_back({{0.5, 1.95}, {3.5, 1.95}});  // along the wall
  const cv::Mat with = drawn(image);
  int changed = 0;
  for (int y = 0; y < with.rows; ++y)
    for (int x = 0; x < with.cols; ++x) changed += with.at<cv::Vec3b>(y, x) != without.at<cv::Vec3b>(y, x) ? 1 : 0;
  EXPECT_GT(changed, 300) << "a line is there";
  EXPECT_LT(changed, 5000) << "but not hundreds";
  EXPECT_EQ(pixels_like(with, {0, 0, 0}), pixels_like(without, {0, 0, 0})) << "walls stay";
}

TEST(MapImage, SurvivesNothingAndTheEndless) {
  EXPECT_FALSE(drawn({}).empty());
  MapImage image;
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  image.path = {{0.0, 0.0}, {no_number, 1.0}, {1e7, -1e7}};
  image.landmarks.push_back({{1.0, 1.0}, Eigen::Matrix2d::Constant(no_number)});
  image.landmarks.push_back({{1.0, 1.0}, 1e30 * Eigen::Matrix2d::Identity()});
  const cv::Mat drawing = drawn(image);
  EXPECT_LE(std::max(drawing.cols, drawing.rows), 1601);
}

TEST(MapImage, KeepsThinWallsOfALargeMap) {
  auto grid = std::make_shared<OccupancyGrid>();
  grid->cell_m = 0.05;
  grid->width = grid->height = 4000;
  for (int y = 0; y < 4000; ++y)
    for (int x = 0; x < 4000; ++x) grid->percent.set(x, y, x == 1001 ? 100 : 0);
  MapImage image;
  image.grid = grid;
  const cv::Mat drawing = drawn(image);
  int rows_with_wall = 0;
  for (int y = 0; y < drawing.rows; ++y)
    for (int x = 380; x < 420; ++x)
      if (drawing.at<cv::Vec3b>(y, x) == cv::Vec3b(0, 0, 0)) {
        ++rows_with_wall;
        break;
      }
  EXPECT_GT(rows_with_wall, drawing.rows - 20);
}

}  // namespace
}  // namespace rastro
