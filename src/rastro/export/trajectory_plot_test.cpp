// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/trajectory_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/trajectory_curves.h"
#include "rastro/export/trajectory_plot_panel.h"

namespace rastro {
namespace {

using testing::HasSubstr;

/// A circle driven twice in the x-z plane: yaw runs to 720 degrees.
TrajectoryPlot circle() {
  TrajectoryPlot plot;
  plot.title = "circle <&>";
  plot.along_label = "frame";
  PlottedEstimate estimate{"run", {}, {}};
  for (int k = 0; k <= 144; ++k) {
    const double yaw = k * 3.14159265358979 / 36.0;
    plot.along.push_back(k);
    plot.reference.push_back(SE3(SO3::exp({0, yaw, 0}), {10 * std::sin(yaw), 0, 10 * std::cos(yaw)}));
    estimate.reference_index.push_back(static_cast<std::size_t>(k));
    estimate.poses.push_back(SE3(SO3::exp({0, yaw + 0.01, 0}), {10.5 * std::sin(yaw), 0, 10.5 * std::cos(yaw)}));
  }
  plot.estimates.push_back(estimate);
  return plot;
}

/// Points of the `number`-th line of this color.
std::vector<Eigen::Vector2d> line_of(const std::string& svg, const std::string& color, int number) {
  std::size_t at = 0;
  for (int k = 0; k <= number; ++k) at = svg.find("stroke=\"" + color + "\"", at) + 1;
  at = svg.find("points=\"", at) + 8;
  std::istringstream text(svg.substr(at, svg.find('"', at) - at));
  std::vector<Eigen::Vector2d> points;
  char comma = ' ';
  for (Eigen::Vector2d point; text >> point.x() >> comma >> point.y();) points.push_back(point);
  return points;
}

TEST(TrajectoryCurves, CsvHasEveryPoseWithItsErrors) {
  TrajectoryPlot plot = circle();
  plot.estimates[0].name = "a \"run\", 1";
  const std::string csv = trajectory_curves_as_csv(plot);
  std::istringstream lines(csv);
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  ASSERT_EQ(rows.size(), 146u);
  EXPECT_EQ(rows[0],
            "estimate,frame,x_m,y_m,z_m,roll_deg,pitch_deg,yaw_deg,error_x_m,error_y_m,error_z_m,error_roll_deg,"
            "error_pitch_deg,error_yaw_deg");
  // A quarter of a turn and two turns: yaw runs on, and its error is 0.01 rad.
  EXPECT_EQ(rows[1 + 36].substr(0, 18), "\"a \"\"run\"\", 1\",36,");
  EXPECT_THAT(rows[1 + 18], HasSubstr(",18,10.500000,0.000000,0.000000,"));
  EXPECT_THAT(rows[1 + 144], HasSubstr(",720.572958,"));
  EXPECT_THAT(rows[1 + 18], HasSubstr(",0.500000,0.000000,0.000000,0.000000,0.000000,0.572958"));
}

TEST(TrajectoryPlot, SvgHoldsTheCurves) {
  const auto file = scratch_path("plot.svg");
  write_trajectory_plot(circle(), file.string());
  const std::string svg = read_whole_file(file);
  EXPECT_THAT(svg, HasSubstr("circle &lt;&amp;&gt;"));
  for (const char* word :
       {">x [m]<", ">error of yaw [deg]<", ">roll [deg]<", "path from above: z [m]", ">frame<", ">run<"})
    EXPECT_THAT(svg, HasSubstr(word));
  // The first color: the legend, then two lines for each row, value and error, then the path.
  const auto yaw = line_of(svg, "#d62728", 11);
  ASSERT_GT(yaw.size(), 100u);
  for (std::size_t k = 1; k < yaw.size(); ++k) EXPECT_LT(yaw[k].y(), yaw[k - 1].y()) << "yaw must run on, not wrap";
  const auto path = line_of(svg, "#d62728", 13);
  Eigen::Vector2d low = path[0], high = path[0];
  for (const auto& point : path) low = low.cwiseMin(point), high = high.cwiseMax(point);
  EXPECT_NEAR((high - low).x(), (high - low).y(), 0.5) << "a circle stays one";
}

TEST(TrajectoryPlot, PngIsAnImageWithTheColors) {
  const auto file = scratch_path("plot.png");
  write_trajectory_plot(circle(), file.string());
  const cv::Mat image = cv::imread(file.string());
  ASSERT_FALSE(image.empty());
  int red = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) red += image.at<cv::Vec3b>(y, x) == cv::Vec3b(40, 39, 214) ? 1 : 0;
  EXPECT_GT(red, 200);
}

TEST(TrajectoryPlot, SmallAndFlatTrajectoriesAreDrawn) {
  TrajectoryPlot plot = circle();
  plot.reference.resize(1);
  plot.along.resize(1);
  plot.estimates[0].reference_index.resize(1);
  plot.estimates[0].poses.resize(1);
  const auto file = scratch_path("one.svg");
  write_trajectory_plot(plot, file.string());
  const std::string svg = read_whole_file(file);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(TrajectoryPlot, OtherNamesAreRefused) {
  EXPECT_THROW(require_plot_name("plot.pdf"), Error);
  EXPECT_THROW(require_plot_name("plot"), Error);
  EXPECT_NO_THROW(require_plot_name("a/b.png"));
}

TEST(TrajectoryPlot, MarksAreRoundNumbers) {
  EXPECT_THAT(round_marks(0.0, 10.0, 5), testing::ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(round_marks(-0.7, 0.6, 3), testing::ElementsAre(-0.5, 0.0, 0.5));
  EXPECT_TRUE(round_marks(1.0, 1.0, 4).empty());
  EXPECT_TRUE(round_marks(1e300, 1e300 * 1.0000000001, 4).size() < 20);
}

}  // namespace
}  // namespace rastro
